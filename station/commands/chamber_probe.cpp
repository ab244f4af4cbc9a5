// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/devices/survey.h"
#include "hal/maps/device_map.h"
#include "station/commands/chamber_address.h"
#include "station/commands/chamber_commands.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string kind_text(hal::SurveyKind kind) {
  switch (kind) {
    case hal::SurveyKind::probe:
      return "probe";
    case hal::SurveyKind::quantity:
      return "quantity";
    case hal::SurveyKind::alarm:
      return "alarm";
  }
  return "";
}

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

json document(const hal::DeviceMap& map, const hal::ChamberSurvey& survey) {
  json entries = json::array();
  for (const hal::SurveyEntry& entry : survey.entries) {
    entries.push_back({{"kind", kind_text(entry.kind)},
                       {"name", entry.name},
                       {"place", entry.place},
                       {"value", number_or_null(entry.value)},
                       {"text", text_or_null(entry.text)},
                       {"active", entry.active ? json(*entry.active) : json()},
                       {"trouble", text_or_null(entry.trouble)}});
  }
  return {{"name", map.name}, {"address", address_text(map)}, {"sound", survey.sound()}, {"entries", entries}};
}

std::string table(const hal::ChamberSurvey& survey) {
  std::vector<std::vector<std::string>> rows = {{"", "name", "found", "where", "trouble"}};
  for (const hal::SurveyEntry& entry : survey.entries) {
    rows.push_back(
        {kind_text(entry.kind), entry.name, entry.text.empty() ? "-" : entry.text, entry.place, entry.trouble});
  }
  return text_table(rows);
}

}  // namespace

base::Status run_chamber_probe(const ChamberProbeCommand& command, Output& output) {
  auto map = hal::read_device_map(command.file);
  if (!map) return base::forward_error(map);
  if (auto set = set_address(command, *map); !set) return set;
  const auto survey = hal::survey_chamber(*map);
  if (!survey) return base::forward_error(survey);
  if (output.json()) {
    if (auto printed = output.print_json(document(*map, *survey)); !printed) return printed;
  } else {
    output.print(fmt::format("{}\n{}", survey->description, table(*survey)));
  }
  if (survey->sound()) return {};
  return base::fail(base::ErrorKind::device, "what stands under 'trouble' must be put right first",
                    survey->description);
}

}  // namespace soak::station
