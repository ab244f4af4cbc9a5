// SPDX-License-Identifier: Apache-2.0
#include "station/nav/unit_drives.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "nav/outages/outage_runner.h"
#include "station/nav/nav_json.h"
#include "station/nav/outage_batch.h"
#include "station/nav/simulated_drive.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// What outages lose does not depend on the rate of the readings, which are means over their intervals; the time that
/// the filter takes does (docs/nav.md, "Impact of a unit's curve").
constexpr int kRate_hz = 10;
constexpr double kTimeConstant_s = 200.0;

nav::ThermalBias curve_of(const calib::Calibration& calibration) {
  return [&calibration](calib::Sensor sensor, double temp_c) { return curve_value(calibration, sensor, temp_c); };
}

/// The filter without the calibration and with it.
std::vector<nav::FilterPipeline> pair_of(const calib::Calibration& calibration) {
  nav::FilterPipeline calibrated = raw_filter();
  calibrated.name = "calibrated";
  calibrated.correction = correction_by(calibration);
  return {raw_filter(), std::move(calibrated)};
}

base::Result<std::vector<nav::OutageResult>> outages_of(const std::vector<nav::Drive>& drives,
                                                        const std::vector<nav::FilterPipeline>& pipelines) {
  std::vector<nav::OutageResult> all;
  for (const nav::Drive& drive : drives) {
    if (auto valid = nav::validate(drive); !valid) return base::forward_error(valid);
    const auto outages = nav::spread_outages(drive, kFirstUnitOutage_s, kUnitOutage_s, kOutagesOfUnitDrive);
    if (!outages) return base::forward_error(outages);
    auto results = nav::run_outages_in_passing(drive, *outages, pipelines);
    if (!results) return base::forward_error(results);
    std::ranges::move(*results, std::back_inserter(all));
  }
  return all;
}

json errors_json(const nav::PipelineSummary& summary) {
  return {{"horizontal_rmse_m", estimate_json(summary.horizontal_rmse_m)},
          {"horizontal_final_m", estimate_json(summary.horizontal_final_m)}};
}

}  // namespace

std::vector<nav::Drive> unit_drives(const calib::Calibration& calibration, const TemperatureCourse& course,
                                    std::size_t number, std::size_t seed) {
  DriveRequest request;
  request.rate_hz = kRate_hz;
  request.errors = nav::ahrs400ca();
  request.temperature = {course.from_c, course.to_c, kTimeConstant_s};
  const nav::ThermalBias curve = curve_of(calibration);
  std::vector<nav::Drive> drives;
  for (std::size_t d = 0; d < number; ++d) {
    request.seed = seed * 1000 + d;
    const CurveResidual residual(calibration, request.seed);
    request.thermal = [&](calib::Sensor sensor, double temp_c) {
      return curve(sensor, temp_c) + residual(sensor, temp_c);
    };
    drives.push_back(simulated_drive(request));
  }
  return drives;
}

nav::Correction correction_by(const calib::Calibration& calibration) { return curve_correction(curve_of(calibration)); }

base::Result<json> unit_drives_json(const calib::Calibration& calibration, const TemperatureCourse& course) {
  const auto states_nothing = [](const calib::SensorCalibration& sensor) {
    return sensor.bias_uncertainty.temp_c.empty();
  };
  if (std::ranges::any_of(calibration.sensors, states_nothing)) return json();
  const auto filters = pair_of(calibration);
  const auto drives = unit_drives(calibration, course, kUnitDrives, kUnitDriveSeed);
  const auto results = outages_of(drives, filters);
  if (!results) return base::forward_error(results);
  std::vector<nav::Pipeline> pipelines;
  for (const nav::FilterPipeline& filter : filters) pipelines.push_back(nav::filter_pipeline(filter));
  const auto summaries = nav::summarize(*results, pipelines, kUnitDriveSeed);
  return json{{"drives", drives.size()},           {"outages", results->size()},
              {"length_s", kUnitOutage_s},         {"without", errors_json(summaries[0])},
              {"with", errors_json(summaries[1])}, {"gain", estimate_json(summaries[1].gain)}};
}

json impact_with_drives_json(const calib::Calibration& calibration) {
  const auto range = whole_range(calibration);
  if (!range) return {};
  json impact = impact_json(calibration, *range);
  auto drives = unit_drives_json(calibration, *range);
  if (drives) {
    impact["drives"] = *std::move(drives);
    return impact;
  }
  impact["drives"] = nullptr;
  const bool by_curves = drives.error().kind == base::ErrorKind::bad_input;
  impact["warnings"].push_back(
      {{"code", "drives_not_simulated"},
       {"text",
        "with these curves no drive can be simulated: " + drives.error().message +
            (by_curves
                 ? "; look at the curves, and record the campaign again where they are not those of an inertial unit"
                 : "; this is a fault of the program: report it")}});
  return impact;
}

}  // namespace soak::station
