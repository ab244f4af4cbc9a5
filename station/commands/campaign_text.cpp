// SPDX-License-Identifier: Apache-2.0
#include "station/commands/campaign_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// A member with so many decimals, "–" where it is not known.
std::string number(const json& object, const char* name, int decimals) {
  const json value = object.value(name, json());
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), decimals) : "–";
}

std::string text(const json& object, const char* name) {
  const json value = object.value(name, json());
  return value.is_string() ? value.get<std::string>() : "–";
}

std::string campaign_lines(const json& status) {
  const json& campaign = status.at("campaign");
  if (campaign.is_null()) return {};
  const double left_s = campaign.at("remaining_s").get<double>();
  const double rate = status.at("clock").at("rate").get<double>();
  std::string lines = fmt::format("campaign   {} ({}, {})\n", text(campaign, "name"), text(campaign, "procedure"),
                                  text(campaign, "purpose"));
  lines += fmt::format("           {}\n", step_text(campaign));
  lines += fmt::format("           {:.0f} % done, {} of process time to go",
                       100.0 * campaign.at("progress").get<double>(), duration_text(left_s));
  if (rate != 1.0) lines += fmt::format(", {} by this clock (rate {})", duration_text(left_s / rate), rate);
  return lines + "\n";
}

std::string chamber_lines(const json& status) {
  const json& chamber = status.at("chamber");
  std::string lines = fmt::format("chamber    {} °C, set point {} °C, output {} %{}\n", number(chamber, "air_c", 2),
                                  number(chamber, "set_point_c", 2), number(chamber, "output_percent", 0),
                                  chamber.at("connected").get<bool>() ? "" : ", NOT CONNECTED");
  for (const json& alarm : chamber.at("alarms")) {
    lines += fmt::format("           alarm: {}\n", alarm.get<std::string>());
  }
  const json& fixture = status.at("fixture");
  lines += fmt::format("fixture    {}{}\n", text(fixture, "position"),
                       fixture.at("connected").get<bool>() ? "" : ", NOT CONNECTED");
  return lines;
}

std::string unit_table(const json& units) {
  if (units.empty()) return {};
  std::vector<std::vector<std::string>> rows = {
      {"slot", "unit", "state", "°C", "K/min", "±", "stable", "position", "samples", "lost"}};
  for (const json& unit : units) {
    rows.push_back({text(unit, "slot"), text(unit, "serial"), text(unit, "state"), number(unit, "temp_c", 2),
                    number(unit, "slope_kpmin", 3), number(unit, "slope_half_width_kpmin", 3),
                    unit.at("stable").get<bool>() ? "yes" : "no", text(unit, "position"), number(unit, "samples", 0),
                    number(unit, "lost", 0)});
  }
  return "\n" + text_table(rows);
}

}  // namespace

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} s", whole);
}

std::string step_text(const json& campaign) {
  return fmt::format("run {} of {}, step {} of {}: {}", campaign.at("run").get<int>(), campaign.at("runs").get<int>(),
                     campaign.at("step").get<int>() + 1, campaign.at("steps").get<int>(), text(campaign, "step_text"));
}

std::string status_text(const json& status) {
  std::string lines =
      fmt::format("state      {}{}\n", text(status, "state"), status.at("simulated").get<bool>() ? " (SIMULATED)" : "");
  if (!status.at("reason").is_null()) lines += fmt::format("           {}\n", text(status, "reason"));
  lines += campaign_lines(status);
  if (!status.at("prompt").is_null()) {
    lines += fmt::format("prompt     {}\n           'soak campaign confirm' answers it\n",
                         text(status.at("prompt"), "text"));
  }
  return lines + chamber_lines(status) + unit_table(status.at("units"));
}

}  // namespace soak::station
