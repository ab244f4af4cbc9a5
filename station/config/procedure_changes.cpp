// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure_changes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/durable.h"
#include "settings/rewrite.h"
#include "station/config/procedure_folder.h"
#include "station/config/set_point_limits.h"
#include "station/io/new_file.h"

namespace soak::station {
namespace {

using nlohmann::json;
using settings::KeyChange;

constexpr const char* kSetPoints = "set_points_c";
constexpr const char* kRuns = "runs";
constexpr const char* kDwell = "dwell_s";
constexpr const char* kSoak = "minimum_soak_s";

bool has_dwell(const Procedure& procedure) { return procedure.kind != ProcedureKind::ramp; }

/// The set points without the visits of the reference plateau at both ends: with it they give the same course again.
std::vector<double> without_reference(const Procedure& procedure) {
  std::vector<double> points = procedure.set_points_c;
  if (!procedure.reference_c || points.size() < 3) return points;
  if (points.front() == *procedure.reference_c) points.erase(points.begin());
  if (points.back() == *procedure.reference_c) points.pop_back();
  return points;
}

/// Changes of keys that one change makes, by the name of the change.
std::vector<std::pair<std::string, std::vector<KeyChange>>> steps_of(const ProcedureChanges& changes) {
  std::vector<std::pair<std::string, std::vector<KeyChange>>> steps;
  if (changes.set_points_c) {
    std::vector<KeyChange> keys = {{"temperatures", "list_c", *changes.set_points_c}};
    for (const char* key : {"start_c", "stop_c", "step_c", "sweep"}) keys.push_back({"temperatures", key, {}});
    steps.emplace_back(kSetPoints, std::move(keys));
  }
  if (changes.runs) steps.push_back({kRuns, {{"", "runs", std::int64_t{*changes.runs}}}});
  if (changes.dwell_s) steps.push_back({kDwell, {{"positions", "dwell_s", *changes.dwell_s}}});
  if (changes.minimum_soak_s) steps.push_back({kSoak, {{"stability", "minimum_soak_s", *changes.minimum_soak_s}}});
  return steps;
}

/// What parse_procedure() would refuse, too, in words for who has never seen the file.
base::Status check_values(const Procedure& procedure, const ProcedureChanges& changes) {
  const auto is_outside = [](double temp_c) { return !(temp_c >= kSetPoint_c.low && temp_c <= kSetPoint_c.high); };
  const auto points = changes.set_points_c.value_or(std::vector<double>{});
  if (const auto found = std::ranges::find_if(points, is_outside); found != points.end()) {
    return base::bad_input(
        fmt::format("{} °C is no set point: they lie between {} and {} °C", *found, kSetPoint_c.low, kSetPoint_c.high),
        kSetPoints);
  }
  if (changes.minimum_soak_s && *changes.minimum_soak_s >= procedure.stability.timeout_s) {
    return base::bad_input(fmt::format("the procedure waits {} s at a set point at most (its stability.timeout_s): the "
                                       "soak must be shorter",
                                       procedure.stability.timeout_s),
                           kSoak);
  }
  return {};
}

base::Status check_kind(const Procedure& procedure, const ProcedureChanges& changes) {
  if (has_dwell(procedure)) return {};
  const std::string why = "a procedure of kind 'ramp' records without a stop: it has no such time";
  if (changes.dwell_s) return base::bad_input(why, kDwell);
  if (changes.minimum_soak_s) return base::bad_input(why, kSoak);
  return {};
}

/// What parse_procedure() says, at the change that it follows from, without the place in a file that nobody sees.
base::Error refused_change(const base::Error& error, const std::string& file, const std::string& change) {
  std::string message = error.message;
  for (std::size_t at = message.find(file + ":"); at != std::string::npos; at = message.find(file + ":", at)) {
    const std::size_t end = message.find(": ", at + file.size() + 1);
    message.erase(at, end == std::string::npos ? file.size() + 1 : end + 2 - at);
  }
  return {base::ErrorKind::bad_input, message, change};
}

/// The head of the new procedure. Its description begins with a sentence of what is changed: what the other one says of
/// itself may not hold any more.
std::vector<KeyChange> head_of(const NewProcedure& made, const Procedure& source) {
  std::string description = fmt::format("Like {}, but with {}.", source.name, changes_text(made.changes));
  if (!source.description.empty())
    description += fmt::format("\n{} says of itself: {}", source.name, source.description);
  return {{"", "name", made.name}, {"", "description", description}};
}

base::Error name_taken(const std::string& name) {
  return {base::ErrorKind::bad_input,
          fmt::format("there is a procedure {}.toml already: it is not written over, choose another name", name),
          "name"};
}

}  // namespace

json changeable_document(const Procedure& procedure) {
  const bool dwells = has_dwell(procedure);
  return {{kSetPoints, without_reference(procedure)},
          {kRuns, procedure.runs},
          {kDwell, dwells ? json(procedure.dwell_s) : json()},
          {kSoak, dwells ? json(procedure.stability.minimum_soak_s) : json()},
          {"reference_c", procedure.reference_c ? json(*procedure.reference_c) : json()}};
}

std::string changes_text(const ProcedureChanges& changes) {
  std::vector<std::string> parts;
  const auto counted = [](auto count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
  };
  if (changes.set_points_c && !changes.set_points_c->empty()) {
    const auto [low, high] = std::ranges::minmax(*changes.set_points_c);
    const std::string count = counted(changes.set_points_c->size(), "set point");
    parts.push_back(low == high ? fmt::format("{} at {} °C", count, low)
                                : fmt::format("{} from {} to {} °C", count, low, high));
  }
  if (changes.runs) parts.push_back(counted(*changes.runs, "run"));
  if (changes.dwell_s) parts.push_back(fmt::format("{} s in each position", *changes.dwell_s));
  if (changes.minimum_soak_s)
    parts.push_back(fmt::format("at least {} s of soak at each set point", *changes.minimum_soak_s));
  return fmt::format("{}", fmt::join(parts, ", "));
}

base::Result<std::string> changed_procedure(std::string_view source, const NewProcedure& made) {
  if (auto named = check_procedure_name(made.name); !named) return base::forward_error(named);
  const auto procedure = parse_procedure(source, made.from);
  if (!procedure) return tl::unexpected(base::Error{base::ErrorKind::bad_input, procedure.error().message, "from"});
  if (auto fits = check_kind(*procedure, made.changes); !fits) return base::forward_error(fits);
  if (auto fits = check_values(*procedure, made.changes); !fits) return base::forward_error(fits);
  const auto steps = steps_of(made.changes);
  if (steps.empty())
    return base::bad_input("nothing is changed: change the set points, or use the procedure as it is", kSetPoints);
  std::string text(source);
  for (const auto& [change, keys] : steps) {
    auto changed = settings::rewritten(text, made.from, keys);
    if (!changed) return tl::unexpected(refused_change(changed.error(), made.from, change));
    text = *std::move(changed);
    if (const auto sound = parse_procedure(text, made.from); !sound) {
      return tl::unexpected(refused_change(sound.error(), made.from, change));
    }
  }
  auto named = settings::rewritten(text, made.from, head_of(made, *procedure));
  if (!named) return tl::unexpected(refused_change(named.error(), made.from, "name"));
  text = fmt::format("# Made from {}, {}: {}.\n", made.from, made.origin, changes_text(made.changes)) + *named;
  if (const auto sound = parse_procedure(text, made.name); !sound) {
    return tl::unexpected(refused_change(sound.error(), made.name, steps.front().first));
  }
  return text;
}

base::Status check_procedure_name(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  const auto is_allowed = [&](char c) { return is_plain(c) || c == '-' || c == '_'; };
  if (!name.empty() && name.size() <= kLongest && is_plain(name.front()) && std::ranges::all_of(name, is_allowed)) {
    return {};
  }
  return base::bad_input(
      fmt::format(
          "the name becomes that of a file: 1 to {} letters of a to z, digits, - and _, a letter or digit first",
          kLongest),
      "name");
}

base::Result<std::string> offered_procedure(const std::vector<std::filesystem::path>& folders,
                                            const std::string& file) {
  const auto path = procedure_file(folders, file);
  if (!path) return base::bad_input(fmt::format("there is no procedure {}", file), "from");
  auto text = procedure_file_text(*path);
  if (!text) return tl::unexpected(base::Error{base::ErrorKind::bad_input, text.error().message, "from"});
  return text;
}

base::Status check_procedure_is_new(const std::vector<std::filesystem::path>& folders, const std::string& name) {
  if (procedure_file(folders, name + ".toml")) return tl::unexpected(name_taken(name));
  return {};
}

base::Result<std::filesystem::path> add_procedure(const std::vector<std::filesystem::path>& folders,
                                                  const std::string& name, std::string_view text) {
  if (auto named = check_procedure_name(name); !named) return base::forward_error(named);
  if (auto is_new = check_procedure_is_new(folders, name); !is_new) return base::forward_error(is_new);
  const std::filesystem::path& folder = folders.front();
  if (auto made = db::create_folders_durably(folder); !made) return base::forward_error(made);
  std::filesystem::path path = folder / (name + ".toml");
  const auto written = write_new_text_file(path, text);
  if (!written) return base::forward_error(written);
  if (!*written) return tl::unexpected(name_taken(name));
  return path;
}

}  // namespace soak::station
