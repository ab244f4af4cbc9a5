// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/truth_writer.h"

#include <fmt/format.h>

#include "base/units.h"
#include "hal/sim/effects/hidden_effects.h"
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
  return json_list(values, [decimals](double value) { return fmt::format("{:.{}f}", value, decimals); });
}

std::string number_list(const calib::Vector3& vector, double factor) {
  return number_list(std::vector<double>{factor * vector[0], factor * vector[1], factor * vector[2]}, 7);
}

std::string sensor_json(const CampaignConfig& config, const SimulatedUnit& unit, const ListedRuns& listed,
                        calib::Sensor sensor) {
  const SimulatedSensor& truth = unit.sensors[calib::index_of(sensor)];
  const bool gyro = calib::is_gyro(sensor);
  const double printed = calib::printed_per_si(sensor);
  const std::vector<double> grid_c = dense_grid_c(config.curve);
  const std::vector<double> bias = values_of(truth.bias, grid_c, printed);
  const auto offset_of = [&](const ListedRun& run) {
    return fmt::format("{:.7f}", printed * power_on_offset(config, unit, run.run, sensor));
  };
  return fmt::format(
      "{{\"unit\": \"{}\", \"uncompensated_span\": {:.7f},\n"
      "     \"power_on_sigma\": {:.7f}, \"power_on_offset\": {}, \"verification_power_on_offset\": {},\n"
      "     \"misalignment_rad\": {}, \"g_sensitivity_dps_per_g\": {},\n"
      "     \"bias\": {},\n     \"scale_ppm\": {}}}",
      calib::printed_unit(sensor), span_of(bias), printed * config.magnitudes(sensor).power_on_sigma,
      json_list(listed.runs, offset_of), listed.verification ? offset_of(*listed.verification) : "null",
      number_list(truth.misalignment, 1.0),
      gyro ? number_list(truth.g_sensitivity, printed * base::kStandardGravity_mps2) : "null", number_list(bias, 7),
      gyro ? "null" : number_list(values_of(truth.scale_ppm, grid_c, 1.0), 3));
}

/// What one hidden effect does to a unit of soaksim: name, amplitude and unit per sensor, shape.
std::string lab_effect_json(const LabEffect& effect, const EffectSurroundings& surroundings) {
  const DrawnEffect& drawn = effect.drawn;
  std::string sensors;
  for (const calib::Sensor sensor : drawn.sensors) {
    sensors += fmt::format("{}\"{}\": {{\"amplitude\": {:.7g}, \"unit\": \"{}\"}}", sensors.empty() ? "" : ", ",
                           calib::name_of(sensor), amplitude_of(drawn, sensor, effect.amplitude),
                           unit_of(*drawn.entry, sensor));
  }
  const ActiveEffect active(drawn, effect.amplitude, surroundings);
  return fmt::format("{{\"name\": \"{}\", \"nameable\": {}, \"sensors\": {{{}}}, \"shape\": {}}}", drawn.entry->name,
                     drawn.entry->nameable, sensors, shape_json(active.shape()));
}

std::string unit_truth_json(const CampaignConfig& config, const SimulatedUnit& unit, int number,
                            const ListedRuns& listed) {
  std::string text = fmt::format("  {{\"unit\": \"{}\", \"sensors\": {{", unit.serial);
  std::string_view separator = "\n";
  for (const calib::Sensor sensor : calib::kSensors) {
    text +=
        fmt::format("{}    \"{}\": {}", separator, calib::name_of(sensor), sensor_json(config, unit, listed, sensor));
    separator = ",\n";
  }
  text += "}";
  if (!config.hidden.empty()) {
    const auto json_of = [&](const LabEffect& effect) { return lab_effect_json(effect, lab_surroundings(config)); };
    text += ",\n   \"hidden\": " + json_list(lab_effects(config, number), json_of);
  }
  return text + "}";
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
  const auto quoted_label = [](const ListedRun& run) { return fmt::format("\"{}\"", run.label); };
  std::string text = fmt::format(
      "{{\"seed\": {}, \"gravity_mps2\": {}, \"runs\": {}, \"verification_run\": {},\n \"temp_c\": {},\n "
      "\"units\": [",
      config.seed, base::kStandardGravity_mps2, json_list(listed.runs, quoted_label),
      listed.verification ? quoted_label(*listed.verification) : "null", number_list(dense_grid_c(config.curve), 2));
  std::string_view separator = "\n";
  int number = 0;
  for (const SimulatedUnit& unit : units) {
    text += separator;
    text += unit_truth_json(config, unit, ++number, listed);
    separator = ",\n";
  }
  return text + "]}\n";
}

}  // namespace soak::hal::sim
