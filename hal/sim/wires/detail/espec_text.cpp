// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/wires/detail/espec_text.h"

#include <fmt/format.h>

#include "base/text.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kSetPointCommand = "TEMP, S";

int alarm_count(const SimulatedChamber& chamber) {
  return int{chamber.alarm_is_on()} + int{chamber.limit_is_tripped()};
}

/// Codes are made up: the maker's list is not public.
std::string alarms(const SimulatedChamber& chamber) {
  return fmt::format("{}{}{}", alarm_count(chamber), chamber.alarm_is_on() ? ",1" : "",
                     chamber.limit_is_tripped() ? ",2" : "");
}

std::string mode(const SimulatedChamber& chamber) { return chamber.controller().is_on() ? "CONSTANT" : "STANDBY"; }

std::string temperatures(const SimulatedChamber& chamber) {
  return fmt::format("{:.1f},{:.1f},{:.1f},{:.1f}", chamber.process_value_c(), chamber.controller().set_point_c(),
                     chamber.set_point_high_c(), chamber.set_point_low_c());
}

std::string change_set_point(SimulatedChamber& chamber, std::string_view line) {
  const auto value = base::parse_double(line.substr(kSetPointCommand.size()));
  if (!value) return "NA:PARA ERR";
  if (!chamber.takes_set_point(*value)) return "NA:DATA OUT OF RANGE";
  chamber.set_set_point_c(*value);
  return fmt::format("OK:{}", line);
}

std::string change_mode(SimulatedChamber& chamber, std::string_view line) {
  chamber.switch_control(line == "MODE,CONSTANT");
  return fmt::format("OK:{}", line);
}

}  // namespace

std::string espec_answer(SimulatedChamber& chamber, std::string_view line) {
  if (line == "TEMP?") return temperatures(chamber);
  if (line == "MODE?") return mode(chamber);
  if (line == "ALARM?") return alarms(chamber);
  if (line == "MON?") {
    return fmt::format("{:.1f},,{},{}", chamber.process_value_c(), mode(chamber), alarm_count(chamber));
  }
  if (line.starts_with(kSetPointCommand)) return change_set_point(chamber, line);
  if (line == "MODE,CONSTANT" || line == "MODE,STANDBY") return change_mode(chamber, line);
  return "NA:CMD ERR";
}

}  // namespace soak::hal::sim
