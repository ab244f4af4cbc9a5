// SPDX-License-Identifier: Apache-2.0
#include "station/setup/settings_change.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "settings/sections.h"
#include "station/config/station_config.h"

namespace soak::station {
namespace {

using settings::Section;

constexpr std::string_view kEquals = " = ";

/// The sections of a text of setup_text(): each key has a line of its own.
std::vector<Section> sections_of(const SetupForm& form) {
  std::vector<Section> sections;
  std::size_t slots = 0;
  std::istringstream lines(setup_text(form).toml);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    if (line == "[[slot]]") {
      sections.push_back({"slot", slots++, {}});
    } else if (line.starts_with('[')) {
      sections.push_back({line.substr(1, line.size() - 2), std::nullopt, {}});
    } else {
      const std::size_t equals = line.find(kEquals);
      sections.back().keys.emplace_back(line.substr(0, equals), line.substr(equals + kEquals.size()));
    }
  }
  return sections;
}

const Section* same_in(const std::vector<Section>& sections, const Section& section) {
  const auto found = std::ranges::find_if(
      sections, [&](const Section& one) { return one.table == section.table && one.index == section.index; });
  return found == sections.end() ? nullptr : &*found;
}

/// A line of the differences; an address that is a secret is not shown.
std::string line_of(char sign, const std::pair<std::string, std::string>& entry) {
  const auto& [key, value] = entry;
  return fmt::format("{} {} = {}\n", sign, key, key == "url" ? "\"...\"" : value);
}

/// The keys of one that the other does not have, or not with this value.
std::string lines_missing_in(char sign, const Section* section, const Section* other) {
  std::string lines;
  if (section == nullptr) return lines;
  for (const auto& entry : section->keys) {
    const bool is_there = other != nullptr && std::ranges::find(other->keys, entry) != other->keys.end();
    if (!is_there) lines += line_of(sign, entry);
  }
  return lines;
}

std::string differences_in(const Section& named, const Section* before, const Section* after) {
  const std::string lines = lines_missing_in('-', before, after) + lines_missing_in('+', after, before);
  const bool comes_or_goes = before == nullptr || after == nullptr;
  if (lines.empty() && !comes_or_goes) return "";
  const char sign = before == nullptr ? '+' : after == nullptr ? '-' : ' ';
  const std::string which = named.index ? fmt::format("  # {}", *named.index + 1) : "";
  return fmt::format("{} {}{}\n{}", sign, header_of(named), which, lines);
}

std::string differences_of(const std::vector<Section>& before, const std::vector<Section>& after) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() || part.empty() ? "" : "\n") + part; };
  for (const Section& section : before) add(differences_in(section, &section, same_in(after, section)));
  for (const Section& section : after) {
    if (same_in(before, section) == nullptr) add(differences_in(section, nullptr, &section));
  }
  return text;
}

/// "chamber: port; slot 1: host, port": which lines differ, but not what they say.
std::string summary_of(const std::vector<Section>& before, const std::vector<Section>& after) {
  std::string text;
  const auto add = [&](const Section& named, const Section* old, const Section* now) {
    std::vector<std::string> keys;
    for (const Section* one : {old, now}) {
      for (const auto& entry : one == nullptr ? Section().keys : one->keys) {
        const Section* other = one == old ? now : old;
        const bool differs = other == nullptr || std::ranges::find(other->keys, entry) == other->keys.end();
        if (differs && std::ranges::find(keys, entry.first) == keys.end()) keys.push_back(entry.first);
      }
    }
    if (keys.empty()) return;
    const std::string which = named.index ? fmt::format("{} {}", named.table, *named.index + 1) : named.table;
    const std::string what = old == nullptr   ? "new"
                             : now == nullptr ? "taken out"
                                              : fmt::format("{}", fmt::join(keys, ", "));
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", which, what);
  };
  for (const Section& section : before) add(section, &section, same_in(after, section));
  for (const Section& section : after) {
    if (same_in(before, section) == nullptr) add(section, nullptr, &section);
  }
  return text;
}

/// A station whose slots name no type of units may leave it so.
void allow_no_type(std::vector<SetupMistake>& mistakes, const SetupForm& before, const SetupForm& form) {
  if (!before.unit_type.empty() || !form.unit_type.empty()) return;
  std::erase_if(mistakes, [](const SetupMistake& mistake) { return mistake.field == "unit_type"; });
}

std::vector<SetupSecret> new_secrets_of(const SetupForm& before, const SetupForm& form) {
  std::vector<std::string> known;
  if (before.mail) known.push_back(password_file_of(*before.mail));
  if (before.webhook) known.insert(known.end(), {before.webhook->url_file, before.webhook->token_file});
  std::vector<SetupSecret> secrets = secrets_of(form);
  std::erase_if(secrets, [&](const SetupSecret& one) { return std::ranges::find(known, one.file) != known.end(); });
  return secrets;
}

/// What a slot has in the file and the page does not show, its mounting (`axes`) above all, stays with the place in the
/// list: it must stay the same slot.
void check_slots_stay(std::string_view text, const std::vector<Section>& before, const SetupForm& old_form,
                      const SetupForm& form, std::vector<SetupMistake>& mistakes) {
  for (const Section& section : before) {
    if (!section.index) continue;
    const std::size_t i = *section.index;
    const std::string& name = old_form.slots[i].name;
    if (i < form.slots.size() && form.slots[i].name == name) continue;
    const auto beyond = settings::keys_beyond(text, section);
    if (beyond.empty()) continue;
    const std::string field = i < form.slots.size() ? fmt::format("slots.{}.name", i) : "";
    mistakes.push_back(
        {field, fmt::format("slot '{}' has more in the file than this page shows ({}): it keeps its name "
                            "and place here; take it out or rename it in the file",
                            name, fmt::join(beyond, ", "))});
  }
}

}  // namespace

SettingsDraft draft_settings(std::string_view text, const std::filesystem::path& file, const SetupForm& before,
                             const SetupForm& form) {
  SettingsDraft draft;
  const auto old_sections = sections_of(before);
  const auto sections = sections_of(form);
  draft.differences = differences_of(old_sections, sections);
  draft.summary = summary_of(old_sections, sections);
  draft.mistakes = check_setup(form, file).mistakes;
  allow_no_type(draft.mistakes, before, form);
  check_slots_stay(text, old_sections, before, form, draft.mistakes);
  if (!draft.mistakes.empty()) return draft;
  auto changed = settings::with_sections(text, file.string(), old_sections, sections);
  if (!changed) {
    draft.mistakes.push_back({"", changed.error().message});
    return draft;
  }
  draft.toml = *std::move(changed);
  draft.new_secrets = new_secrets_of(before, form);
  if (const auto config = parse_station_config(draft.toml, file); !config) {
    draft.mistakes.push_back({"", "with what else stands in the file: " + config.error().message});
  }
  return draft;
}

std::string revision_of(std::string_view text) {
  base::Sha256 hash;
  hash.update(text);
  return base::to_hex(hash.finish());
}

std::filesystem::path file_before(const std::filesystem::path& file) { return file.string() + ".before"; }

base::Status write_settings(const std::filesystem::path& file, std::string_view old_text, const SettingsDraft& draft) {
  std::error_code failure;
  const auto mode = std::filesystem::status(file, failure).permissions();
  if (failure) return base::fail(base::ErrorKind::internal, failure.message(), file.string());
  if (auto kept = write_with_mode(file_before(file), old_text, mode); !kept) return kept;
  if (auto written = write_secrets(file.parent_path(), draft.new_secrets); !written) return written;
  return write_with_mode(file, draft.toml, mode);
}

}  // namespace soak::station
