// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/truth_writer.h"

#include <fmt/format.h>

#include "base/units.h"
#include "hal/sim/effects/effect_text.h"
#include "hal/sim/unit/thermal_curve.h"

namespace soak::hal::sim {
namespace {

std::vector<double> values_of(const ThermalCurve& curve, const std::vector<double>& grid_c, double factor) {
  std::vector<double> values;
  values.reserve(grid_c.size());
  for (const double temp_c : grid_c) values.push_back(factor * curve.at(temp_c));
  return values;
}

std::string number_list(const std::vector<double>& values, int decimals) {
  std::string text = "[";
  for (const double value : values) fmt::format_to(std::back_inserter(text), "{:.{}f}, ", value, decimals);
  if (!values.empty()) text.resize(text.size() - 2);
  return text + "]";
}

std::string sensor_json(const CampaignConfig& config, const SimulatedUnit& unit, const ListedRuns& listed,
                        calib::Sensor sensor) {
  const SimulatedSensor& truth = unit.sensors[calib::index_of(sensor)];
  const double printed = calib::printed_per_si(sensor);
  const std::vector<double> grid_c = dense_grid_c(config.curve);
  const std::vector<double> bias = values_of(truth.bias, grid_c, printed);
  std::vector<double> offsets;
  for (const ListedRun& run : listed.runs) {
    offsets.push_back(printed * power_on_offset(config, unit, run.run, sensor));
  }
  std::string verification = "null";
  if (listed.verification) {
    verification = fmt::format("{:.7f}", printed * power_on_offset(config, unit, listed.verification->run, sensor));
  }
  std::string scale = "null";
  std::string g_sensitivity = "null";
  if (calib::is_gyro(sensor)) {
    const double per_g = printed * base::kStandardGravity_mps2;
    const calib::Vector3& g = truth.g_sensitivity;
    g_sensitivity = number_list({per_g * g[0], per_g * g[1], per_g * g[2]}, 7);
  } else {
    scale = number_list(values_of(truth.scale_ppm, grid_c, 1.0), 3);
  }
  const calib::Vector3& tilt = truth.misalignment;
  return fmt::format(
      "{{\"unit\": \"{}\", \"uncompensated_span\": {:.7f},\n"
      "     \"power_on_sigma\": {:.7f}, \"power_on_offset\": {}, \"verification_power_on_offset\": {},\n"
      "     \"misalignment_rad\": {}, \"g_sensitivity_dps_per_g\": {},\n"
      "     \"bias\": {},\n     \"scale_ppm\": {}}}",
      calib::printed_unit(sensor), span_of(bias), printed * config.magnitudes(sensor).power_on_sigma,
      number_list(offsets, 7), verification, number_list({tilt[0], tilt[1], tilt[2]}, 7), g_sensitivity,
      number_list(bias, 7), scale);
}

std::string unit_json(const CampaignConfig& config, const SimulatedUnit& unit, int number, const ListedRuns& listed) {
  std::string text = fmt::format("  {{\"unit\": \"{}\", \"sensors\": {{", unit.serial);
  std::string_view separator = "\n";
  for (const calib::Sensor sensor : calib::kSensors) {
    text +=
        fmt::format("{}    \"{}\": {}", separator, calib::name_of(sensor), sensor_json(config, unit, listed, sensor));
    separator = ",\n";
  }
  text += "}";
  if (!config.hidden.empty()) text += ",\n   \"hidden\": " + lab_effects_json(config, number);
  return text + "}";
}

std::string run_labels(const ListedRuns& listed) {
  std::string text = "[";
  std::string_view separator;
  for (const ListedRun& run : listed.runs) {
    text += fmt::format("{}\"{}\"", separator, run.label);
    separator = ", ";
  }
  return text + "]";
}

std::string verification_label(const ListedRuns& listed) {
  return listed.verification ? fmt::format("\"{}\"", listed.verification->label) : "null";
}

}  // namespace

ListedRuns campaign_runs(const CampaignConfig& config) {
  ListedRuns listed;
  for (int run = 1; run <= config.runs; ++run) listed.runs.push_back({run_label(run), run});
  listed.verification = ListedRun{run_label(kVerificationRun), kVerificationRun};
  return listed;
}

std::string truth_json(const CampaignConfig& config, const std::vector<SimulatedUnit>& units,
                       const ListedRuns& listed) {
  std::string text = fmt::format(
      "{{\"seed\": {}, \"gravity_mps2\": {}, \"runs\": {}, \"verification_run\": {},\n \"temp_c\": {},\n "
      "\"units\": [",
      config.seed, base::kStandardGravity_mps2, run_labels(listed), verification_label(listed),
      number_list(dense_grid_c(config.curve), 2));
  std::string_view separator = "\n";
  int number = 0;
  for (const SimulatedUnit& unit : units) {
    text += separator;
    text += unit_json(config, unit, ++number, listed);
    separator = ",\n";
  }
  return text + "]}\n";
}

}  // namespace soak::hal::sim
