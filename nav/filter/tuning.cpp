// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/tuning.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_fit.h"
#include "nav/filter/alignment.h"
#include "nav/geometry/earth.h"

namespace soak::nav {
namespace {

using calib::Sensor;

constexpr double kShortestRest_s = 20.0;
/// Averaging times end at a quarter of the rest: beyond, a deviation is a mean of three differences or fewer.
constexpr std::size_t kShare = 4;
constexpr std::size_t kPerDecade = 8;

double reading_of(const ImuSample& sample, Sensor sensor) {
  const auto axis = static_cast<Eigen::Index>(calib::axis_of(sensor));
  return calib::is_gyro(sensor) ? sample.rate_rps(axis) : sample.force_mps2(axis);
}

base::Result<SensorModel> model_of_rest(const std::vector<double>& readings, double rate_hz, double start_sigma,
                                        StartOfBias start) {
  const auto record = calib::signal::PhaseRecord::from_rate(readings, rate_hz);
  if (!record) return base::forward_error(record);
  const auto multiples = calib::signal::log_spaced_multiples(readings.size() / kShare, kPerDecade);
  const auto fit = calib::signal::fit_allan(calib::signal::overlapping_curve(*record, multiples));
  if (!fit) return base::forward_error(fit);
  return sensor_model_of(*fit, start_sigma, start);
}

/// What align() leaves of the Earth's rotation in the gyros' biases by a wrong heading: its horizontal part times the
/// heading's error, to the east. Where the body axes point is not asked: each that lies horizontally is taken for east.
Eigen::Vector3d left_of_earth_rate_rps(const Drive& drive, double rest_end_s, double heading_sigma_rad) {
  Eigen::Vector3d force_mps2 = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : drive.imu) {
    if (sample.t_s > rest_end_s) break;
    force_mps2 += sample.force_mps2;
  }
  const Eigen::Vector3d up = force_mps2.normalized();
  const Eigen::Vector3d level = (1.0 - up.array().square()).max(0.0).sqrt();
  return heading_sigma_rad * earth_rate_rps(drive.gnss.front().position.latitude_rad).y() * level;
}

}  // namespace

SensorModels tuned_at_rest(const Drive& drive, const SensorModels& otherwise, double heading_sigma_rad) {
  SensorModels models = otherwise;
  const double first_s = drive.imu.front().t_s;
  const double rest_s = end_of_rest_s(drive) - first_s;
  if (rest_s < kShortestRest_s) return models;
  const Eigen::Vector3d earth_sigma_rps = left_of_earth_rate_rps(drive, first_s + rest_s, heading_sigma_rad);
  for (const Sensor sensor : calib::kSensors) {
    SensorModel& model = models[calib::index_of(sensor)];
    std::vector<double> readings;
    for (const ImuSample& sample : drive.imu) {
      if (sample.t_s - first_s > rest_s) break;
      readings.push_back(reading_of(sample, sensor));
    }
    const StartOfBias start = calib::is_gyro(sensor) ? StartOfBias::known : StartOfBias::unknown;
    const double rate_hz = static_cast<double>(readings.size()) / rest_s;
    const auto tuned = model_of_rest(readings, rate_hz, model.bias.start_sigma, start);
    if (!tuned) continue;
    // A rest shows what the sensor does at the least: driving shakes it, and its temperature moves.
    const double walk = std::max(model.bias.walk, tuned->bias.walk);
    model.white = std::max(model.white, tuned->white);
    model.bias = tuned->bias;
    model.bias.walk = walk;
    if (calib::is_gyro(sensor)) {
      const double moved = std::hypot(model.bias.sigma, model.bias.walk * std::sqrt(rest_s));
      model.bias.start_sigma = std::hypot(model.white / std::sqrt(rest_s), moved,
                                          earth_sigma_rps(static_cast<Eigen::Index>(calib::axis_of(sensor))));
    }
  }
  return models;
}

}  // namespace soak::nav
