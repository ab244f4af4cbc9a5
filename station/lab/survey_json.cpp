// SPDX-License-Identifier: Apache-2.0
#include "station/lab/survey_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <variant>

#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

}  // namespace

std::string address_text(const hal::DeviceMap& map) {
  if (const auto* tcp = std::get_if<hal::TcpAddress>(&map.link.address)) {
    return fmt::format("tcp {}:{}", tcp->host, tcp->port);
  }
  const auto& line = std::get<hal::SerialAddress>(map.link.address);
  return fmt::format("serial {} at {} baud, 8{}{}", line.device, line.baud, line.parity, line.stop_bits);
}

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

json survey_document(const hal::DeviceMap& map, const hal::ChamberSurvey& survey) {
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

}  // namespace soak::station
