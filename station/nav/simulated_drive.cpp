// SPDX-License-Identifier: Apache-2.0
#include "station/nav/simulated_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "nav/scenario/trajectory.h"

namespace soak::station {
namespace {

using base::kRadPerDeg;

constexpr int kRest_s = 40;
/// Calgary, where the thesis' van drove.
constexpr nav::Geodetic kOrigin{51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0};
/// Streams of random numbers beside those of the drive's own errors.
constexpr std::uint64_t kResidualStream = 500;
constexpr double kNormal95 = 1.959964;

const calib::SensorCalibration* part_of(const calib::Calibration& calibration, calib::Sensor sensor) {
  const auto found = std::ranges::find(calibration.sensors, sensor, &calib::SensorCalibration::sensor);
  return found == calibration.sensors.end() ? nullptr : &*found;
}

}  // namespace

nav::Drive simulated_drive(const DriveRequest& request) {
  const auto maneuvers = nav::town_drive(request.duration_s, kRest_s, request.seed);
  base::Random random(request.seed, kResidualStream - 1);
  const nav::Trajectory trajectory(kOrigin, random.uniform(-3.0, 3.0), maneuvers);
  nav::Drive drive = trajectory.drive(request.rate_hz, request.rate_hz, {0.2, 0.8, 0.6});
  drive.name = fmt::format("simulated {}", request.seed);
  nav::add_errors(drive.imu, request.errors, request.temperature, request.thermal, request.seed);
  drive.gnss = nav::simulated_fixes(drive.truth, 1, {}, request.seed);
  return drive;
}

double example_curve(calib::Sensor sensor, double temp_c) {
  constexpr double kMiddle_c[] = {10.0, 25.0, 40.0, 5.0, 20.0, 35.0};
  const double half = calib::is_gyro(sensor) ? 0.25 * kRadPerDeg : 0.025;
  return half * std::tanh((temp_c - kMiddle_c[calib::index_of(sensor)]) / 25.0);
}

CurveResidual::CurveResidual(const calib::Calibration& calibration, std::uint64_t seed) {
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t s = calib::index_of(sensor);
    parts_[s] = {part_of(calibration, sensor), base::hashed_gaussian(seed, kResidualStream + s, 0),
                 base::hashed_gaussian(seed, kResidualStream + s, 1)};
  }
}

double CurveResidual::operator()(calib::Sensor sensor, double temp_c) const {
  const Part& part = parts_[calib::index_of(sensor)];
  if (part.calibration == nullptr) return 0.0;
  const double low_c = part.calibration->temp_min_c;
  const double high_c = part.calibration->temp_max_c;
  const double share = std::clamp((temp_c - low_c) / std::max(high_c - low_c, 1e-9), 0.0, 1.0);
  // The mean of two independent numbers scatters less than they do: the divisor keeps 1 everywhere.
  const double drawn = ((1.0 - share) * part.at_low + share * part.at_high) / std::hypot(1.0 - share, share);
  return drawn * half_width(part.calibration->bias_uncertainty, temp_c) / kNormal95;
}

double half_width(const calib::UncertaintyTable& table, double temp_c) {
  if (table.temp_c.empty()) return 0.0;
  const std::vector<double>& widths = table.pi95.empty() ? table.ci95 : table.pi95;
  if (temp_c <= table.temp_c.front()) return widths.front();
  if (temp_c >= table.temp_c.back()) return widths.back();
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(table.temp_c, temp_c) - table.temp_c.begin());
  return std::lerp(widths[above - 1], widths[above],
                   (temp_c - table.temp_c[above - 1]) / (table.temp_c[above] - table.temp_c[above - 1]));
}

double curve_value(const calib::Calibration& calibration, calib::Sensor sensor, double temp_c) {
  const calib::SensorCalibration* part = part_of(calibration, sensor);
  return part == nullptr ? 0.0 : calib::evaluate(part->bias, temp_c);
}

nav::Correction curve_correction(nav::ThermalBias curve) {
  return [curve = std::move(curve)](nav::ImuSample& sample) {
    for (const calib::Sensor sensor : calib::kSensors) {
      const auto axis = static_cast<Eigen::Index>(calib::axis_of(sensor));
      (calib::is_gyro(sensor) ? sample.rate_rps : sample.force_mps2)(axis) -= curve(sensor, sample.temp_c);
    }
  };
}

}  // namespace soak::station
