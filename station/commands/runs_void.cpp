// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "station/commands/runs_command.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

bool matches(const calib::SegmentKey& key, const RunsVoidCommand& command) {
  return key.visit == command.visit.value_or(key.visit) && key.position == command.position.value_or(key.position) &&
         key.attempt == command.attempt.value_or(key.attempt);
}

std::string listed(const std::vector<calib::Segment>& segments) {
  std::string text;
  for (const calib::Segment& segment : segments) {
    text += fmt::format("{}{}/{}/{}", text.empty() ? "" : ", ", segment.key.visit, segment.key.position,
                        segment.key.attempt);
  }
  return text.empty() ? "none" : text;
}

template <class T>
nlohmann::json value_or_null(const std::optional<T>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json document(const db::RunRow& run, const db::VoidRecord& record, std::ptrdiff_t withdrawn,
                        std::size_t counted) {
  return {{"run", run.label},
          {"run_id", run.run_id},
          {"unit", run.unit},
          {"visit", value_or_null(record.visit)},
          {"position", value_or_null(record.position)},
          {"attempt", value_or_null(record.attempt)},
          {"reason", record.reason},
          {"user", record.user},
          {"utc_s", record.utc_s},
          {"segments_withdrawn", withdrawn},
          {"segments_before", counted}};
}

base::Status check(const RunsVoidCommand& command) {
  if (command.reason.empty()) return base::bad_input("a void record needs a reason", "--reason");
  if (auto plain = check_text_line(command.reason, "--reason"); !plain) return plain;
  if (command.position && !command.visit) return base::bad_input("--position needs --visit", "--position");
  if (command.attempt && !command.position) return base::bad_input("--attempt needs --position", "--attempt");
  return {};
}

}  // namespace

base::Status run_runs_void(const RunsVoidCommand& command, Output& output) {
  if (auto status = check(command); !status) return status;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto run = find_run(*catalog, command.filter);
  if (!run) return base::forward_error(run);
  if (run->voided) {
    return base::bad_input("the whole run is voided already: there is nothing left to withdraw", run->run_id);
  }
  const auto segments = catalog->segments(run->run_id, run->unit, false);
  if (!segments) return base::forward_error(segments);
  const auto withdrawn =
      std::count_if(segments->begin(), segments->end(), [&](const auto& s) { return matches(s.key, command); });
  if (command.visit && withdrawn == 0) {
    return base::bad_input(
        fmt::format("the run has no such segment that still counts; it has (visit/position/attempt): {}",
                    listed(*segments)),
        run->run_id);
  }
  const std::string user = command.user.empty() ? user_name() : command.user;
  const db::VoidRecord record{run->run_id,     run->unit,      command.visit, command.position,
                              command.attempt, command.reason, user,          now_utc_s()};
  if (auto status = catalog->add_void(record); !status) return status;
  if (output.json()) return output.print_json(document(*run, record, withdrawn, segments->size()));
  output.print(
      fmt::format("run {} ({}): {} of {} segments withdrawn\n", run->label, run->run_id, withdrawn, segments->size()));
  return {};
}

}  // namespace soak::station
