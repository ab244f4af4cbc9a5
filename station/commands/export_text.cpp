// SPDX-License-Identifier: Apache-2.0
#include "station/commands/export_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "station/io/output.h"

namespace soak::station {

nlohmann::json losses_document(const calib::AutopilotFile& file) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const calib::CubicLoss& loss : file.losses) {
    const double factor = calib::printed_per_si(loss.sensor);
    sensors[std::string(calib::name_of(loss.sensor))] = {
        {"unit", calib::printed_unit(loss.sensor)},
        {"temp_min_c", loss.temp_min_c},
        {"temp_max_c", loss.temp_max_c},
        {"reference_c", loss.reference_c},
        {"rms", loss.rms * factor},
        {"worst", loss.worst * factor},
        {"worst_temp_c", loss.worst_temp_c},
        {"ci95_at_worst", loss.ci95_at_worst * factor},
        {"beyond_ci95", loss.beyond_ci95},
        {"steepest_per_c", loss.steepest_per_c * factor},
        {"scale_ppm", loss.scale_ppm ? nlohmann::json(*loss.scale_ppm) : nlohmann::json()}};
  }
  return {{"cubic", std::move(sensors)}, {"notes", file.notes}};
}

std::string losses_text(const calib::AutopilotFile& file) {
  std::vector<std::vector<std::string>> table = {
      {"loss of the cubic", "rms", "worst", "at degC", "ci95 there", "beyond ci95", "unit"}};
  for (const calib::CubicLoss& loss : file.losses) {
    const double factor = calib::printed_per_si(loss.sensor);
    table.push_back({std::string(calib::name_of(loss.sensor)), fmt::format("{:.3g}", loss.rms * factor),
                     fmt::format("{:.3g}", loss.worst * factor), fmt::format("{:.1f}", loss.worst_temp_c),
                     fmt::format("{:.3g}", loss.ci95_at_worst * factor),
                     fmt::format("{:.0f} %", 100.0 * loss.beyond_ci95), std::string(calib::printed_unit(loss.sensor))});
  }
  std::string text = text_table(table);
  for (const std::string& note : file.notes) text += "- " + note + '\n';
  return text;
}

nlohmann::json noise_document(const calib::KalibrSource& source, const calib::KalibrFile& file) {
  nlohmann::json values = nlohmann::json::object();
  for (const calib::KalibrValue& value : file.values) {
    values[value.key] = {
        {"value", value.value}, {"worst_axis", calib::name_of(value.worst)}, {"upper_bound", value.bound}};
  }
  return {{"noise", {{"run", source.run}, {"temp_c", source.temp_c}, {"values", std::move(values)}}}};
}

std::string noise_text(const calib::KalibrSource& source, const calib::KalibrFile& file) {
  std::vector<std::vector<std::string>> table = {{"run " + source.run, "SI", "worst axis", ""}};
  for (const calib::KalibrValue& value : file.values) {
    table.push_back({value.key, fmt::format("{:.4g}", value.value), std::string(calib::name_of(value.worst)),
                     value.bound ? "upper bound" : "measured"});
  }
  return text_table(table);
}

}  // namespace soak::station
