// SPDX-License-Identifier: Apache-2.0
#include "station/http/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

namespace soak::station {
namespace {

using nlohmann::json;

/// A metric that stands for one member of an object.
struct Metric {
  std::string_view name;
  std::string_view help;
  std::string_view member;
  std::string_view type = "gauge";
};

constexpr std::array<std::string_view, 10> kStates = {"idle",     "preflight",   "running",  "waiting", "paused",
                                                      "stopping", "interrupted", "finished", "aborted", "failed"};

/// What a campaign waits for by itself, docs/campaigns.md.
constexpr std::array<std::string_view, 6> kCauses = {"chamber", "air", "disk", "storage", "supply", "catalog"};

constexpr std::array<Metric, 7> kChamber = {
    {{"soak_chamber_connected", "Whether the chamber answers.", "connected"},
     {"soak_chamber_air_celsius", "Air temperature that the chamber reports.", "air_c"},
     {"soak_chamber_set_point_celsius", "Set point of the chamber.", "set_point_c"},
     {"soak_chamber_output_percent", "Heating (positive) or cooling output.", "output_percent"},
     {"soak_chamber_humidity_percent", "Relative humidity of the air.", "air_rh_percent"},
     {"soak_chamber_running", "Whether the control of the chamber is on.", "running"},
     {"soak_chamber_reading_age_seconds", "Age of the chamber's last answer.", "age_s"}}};

constexpr std::array<Metric, 5> kCampaign = {
    {{"soak_campaign_progress_ratio", "Share of the campaign that is done.", "progress"},
     {"soak_campaign_remaining_seconds", "Estimated time to its end.", "remaining_s"},
     {"soak_campaign_step", "Step of the plan, from 0.", "step"},
     {"soak_campaign_steps", "Steps of the plan.", "steps"},
     {"soak_campaign_run", "Run, from 1.", "run"}}};

constexpr std::array<Metric, 7> kUnit = {
    {{"soak_unit_temperature_celsius", "Temperature of the unit's own thermometer.", "temp_c"},
     {"soak_unit_slope_kelvins_per_minute", "Slope of that temperature.", "slope_kpmin"},
     {"soak_unit_stable", "Whether that temperature stands still.", "stable"},
     {"soak_unit_supply_volts", "Voltage at the unit's output.", "supply_v"},
     {"soak_unit_supply_amperes", "Current at the unit's output.", "supply_a"},
     {"soak_unit_samples_total", "Samples received in this campaign.", "samples", "counter"},
     {"soak_unit_lost_packets_total", "Packets lost in this campaign.", "lost", "counter"}}};

/// A label's value with what the format escapes.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\\\";
    else if (c == '"')
      result += "\\\"";
    else if (c == '\n')
      result += "\\n";
    else
      result += c;
  }
  return result;
}

std::string head(const Metric& metric) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", metric.name, metric.help, metric.type);
}

/// One sample; nothing where the value is not known.
std::string sample(std::string_view name, std::string_view labels, const json& value) {
  const std::string braces = labels.empty() ? "" : fmt::format("{{{}}}", labels);
  if (value.is_boolean()) return fmt::format("{}{} {}\n", name, braces, value.get<bool>() ? 1 : 0);
  if (!value.is_number() || !std::isfinite(value.get<double>())) return {};
  return fmt::format("{}{} {}\n", name, braces, value.dump());
}

template <std::size_t N>
std::string samples_of(const json& object, const std::array<Metric, N>& metrics, std::string_view labels) {
  std::string text;
  if (!object.is_object()) return text;
  for (const Metric& metric : metrics) {
    const std::string line = sample(metric.name, labels, object.value(std::string(metric.member), json()));
    if (!line.empty()) text += head(metric) + line;
  }
  return text;
}

/// The samples of all units, metric by metric: the format wants those of one name together.
std::string unit_samples(const json& units) {
  std::string text;
  for (const Metric& metric : kUnit) {
    std::string lines;
    for (const json& unit : units) {
      const std::string labels =
          fmt::format("slot=\"{}\",serial=\"{}\"", escaped(unit.value("slot", "")), escaped(unit.value("serial", "")));
      lines += sample(metric.name, labels, unit.value(std::string(metric.member), json()));
    }
    if (!lines.empty()) text += head(metric) + lines;
  }
  std::string streaming;
  for (const json& unit : units) {
    streaming += fmt::format("soak_unit_streaming{{slot=\"{}\",serial=\"{}\"}} {}\n", escaped(unit.value("slot", "")),
                             escaped(unit.value("serial", "")), unit.value("state", "") == "streaming" ? 1 : 0);
  }
  if (streaming.empty()) return text;
  return text + head({"soak_unit_streaming", "Whether the unit sends samples.", ""}) + streaming;
}

std::string state_samples(const json& status) {
  std::string text = head({"soak_state", "1 for the state that the station is in.", ""});
  for (const std::string_view state : kStates) {
    text += fmt::format("soak_state{{state=\"{}\"}} {}\n", state, status.value("state", "") == state ? 1 : 0);
  }
  return text;
}

std::string suspension_samples(const json& suspension) {
  const json causes = suspension.is_object() ? suspension.value("causes", json::array()) : json::array();
  std::string text = head({"soak_suspended", "1 for each cause for which the campaign waits by itself.", ""});
  for (const std::string_view cause : kCauses) {
    const bool waits = std::find(causes.begin(), causes.end(), cause) != causes.end();
    text += fmt::format("soak_suspended{{cause=\"{}\"}} {}\n", cause, waits ? 1 : 0);
  }
  return text;
}

}  // namespace

std::string metrics_text(const json& status, const HostFigures& host) {
  std::string text = head({"soak_info", "Version of soakd.", ""}) +
                     fmt::format("soak_info{{version=\"{}\"}} 1\n", escaped(status.value("version", "")));
  text += state_samples(status);
  text += head({"soak_prompt_open", "Whether the operator is asked for something.", ""}) +
          fmt::format("soak_prompt_open {}\n", status.value("prompt", json()).is_null() ? 0 : 1);
  text += suspension_samples(status.value("suspension", json()));
  text += head({"soak_queue_campaigns", "Campaigns that wait for their turn.", ""}) +
          fmt::format("soak_queue_campaigns {}\n",
                      status.value("queue", json::object()).value("campaigns", json::array()).size());
  const json chamber = status.value("chamber", json());
  text += samples_of(chamber, kChamber, "");
  if (chamber.is_object()) {
    text += head({"soak_chamber_alarms", "Alarms that the chamber reports.", ""}) +
            fmt::format("soak_chamber_alarms {}\n", chamber.value("alarms", json::array()).size());
  }
  text += samples_of(status.value("campaign", json()), kCampaign, "");
  text += unit_samples(status.value("units", json::array()));
  if (std::isfinite(host.disk_free_bytes)) {
    text += head({"soak_disk_free_bytes", "Space that is left for recordings.", ""}) +
            fmt::format("soak_disk_free_bytes {:.0f}\n", host.disk_free_bytes);
  }
  text += head({"soak_heap_bytes", "Memory that soakd has allocated and uses.", ""}) +
          fmt::format("soak_heap_bytes {:.0f}\n", host.heap_bytes);
  return text;
}

}  // namespace soak::station
