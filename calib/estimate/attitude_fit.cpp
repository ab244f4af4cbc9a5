// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/attitude_fit.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"
#include "base/units.h"
#include "calib/estimate/hand_turns.h"
#include "calib/estimate/multi_position.h"

namespace soak::calib {
namespace {

constexpr double kLargestAttitudeScaleError = 0.2;
constexpr std::size_t kAttitudesForLine = 10;
constexpr double kAttitudeChance = 0.8;  ///< probability of a χ² up to which standard errors are believed
constexpr Eigen::Index kUpColumn = 1;
constexpr Eigen::Index kLineColumn = 4;

bool has_triad(const Segment& segment, std::size_t first) {
  return segment.sensor[first].count > 0 && segment.sensor[first + 1].count > 0 && segment.sensor[first + 2].count > 0;
}

Vector3 means_of(const Segment& segment, std::size_t first) {
  return {segment.sensor[first].mean, segment.sensor[first + 1].mean, segment.sensor[first + 2].mean};
}

Vector3 direction_of_vector(const Vector3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

double middle_s(const Segment& segment) { return 0.5 * (segment.t_start_s + segment.t_end_s); }

/// What the estimate of a session belongs to: its mean temperature and time.
PlateauEstimate session_plateau_of(std::span<const Segment> segments, Sensor sensor) {
  PlateauEstimate plateau;
  plateau.visit = segments.front().key.visit;
  plateau.sweep = segments.front().sweep;
  plateau.plateau_c = segments.front().plateau_c;
  double count = 0.0;
  for (const Segment& segment : segments) {
    if (segment.sensor[index_of(sensor)].count == 0) continue;
    count += 1.0;
    plateau.temp_c += (segment.sensor_temp_c[index_of(sensor)] - plateau.temp_c) / count;
    plateau.t_s += (middle_s(segment) - plateau.t_s) / count;
  }
  return plateau;
}

// The accelerometers.

double value_of(const TriadCalibration& triad, TriadParameter first, std::size_t axis) {
  return triad.value[index_of(first) + axis];
}
double error_of(const TriadCalibration& triad, TriadParameter first, std::size_t axis) {
  return triad.standard_error[index_of(first) + axis];
}

/// Rows of K: raw = diag(k)·M·f + b, so entry ij beyond the scale is k_i·m_ij.
void read_triad(std::span<const Segment> segments, const TriadCalibration& triad, SixPositionEstimate& result) {
  constexpr std::array<std::array<int, 3>, 3> kMisalignment = {{{-1, 6, 7}, {-1, -1, 8}, {-1, -1, -1}}};
  const bool shown = std::all_of(triad.observable.begin() + 6, triad.observable.end(), [](bool seen) { return seen; });
  // Only where the residuals made the errors are those uncertain themselves.
  const double freedoms = triad.lack_of_fit_mps2 > 0.0 ? static_cast<double>(triad.degrees_of_freedom) : 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    PlateauEstimate plateau = session_plateau_of(segments, kSensors[3 + i]);
    plateau.bias = value_of(triad, TriadParameter::bias_x, i);
    plateau.bias_se = error_of(triad, TriadParameter::bias_x, i);
    const double scale = value_of(triad, TriadParameter::scale_x, i);
    plateau.scale_ppm = 1e6 * (scale - 1.0);
    plateau.scale_se_ppm = 1e6 * error_of(triad, TriadParameter::scale_x, i);
    plateau.bias_freedoms = plateau.scale_freedoms = freedoms;
    SensorEstimate& sensor = result.sensor[3 + i];
    sensor.plateaus = {plateau};
    sensor.reduced_chi_squared = triad.reduced_chi_squared;
    sensor.coupling_freedoms = freedoms;
    for (std::size_t j = 0; j < 3 && shown; ++j) {
      const int at = kMisalignment[i][j];
      sensor.coupling[j] = at < 0 ? 0.0 : scale * triad.value[static_cast<std::size_t>(at)];
      sensor.coupling_se[j] = at < 0 ? 0.0 : scale * triad.standard_error[static_cast<std::size_t>(at)];
    }
  }
  if (shown) return;
  result.warnings.push_back(
      {"misalignment_not_seen",
       fmt::format("{} attitudes do not show all of the accelerometers' misalignment, which counts as 0: add attitudes "
                   "between the faces (each pair of axes sharing gravity)",
                   triad.residual_mps2.size())});
}

base::Status check_scale(const SixPositionEstimate& result) {
  for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) {
    const double error = 1e-6 * *result.sensor[index_of(sensor)].plateaus.front().scale_ppm;
    if (std::abs(error) <= kLargestAttitudeScaleError) continue;
    return base::bad_input(
        fmt::format("{} reads {:.3g} times gravity over the attitudes: check the unit in the column's name (or its "
                    "scale in the columns map), then void the run and import it into a new campaign",
                    name_of(sensor), 1.0 + error),
        std::string(name_of(sensor)));
  }
  return {};
}

// The gyros at rest.

/// One gyro over the rests: bias, response to gravity, line in time.
void fit_gyro(std::span<const Segment> rests, std::span<const Vector3> ups, Sensor sensor, const Place& place,
              const UnitType& type, SensorEstimate& estimate) {
  const std::size_t s = index_of(sensor);
  const auto n = static_cast<Eigen::Index>(rests.size());
  const bool line = rests.size() >= kAttitudesForLine;
  const PlateauEstimate plateau = session_plateau_of(rests, sensor);
  const double length_s = std::max(1.0, rests.back().t_end_s - rests.front().t_start_s);
  const double unknown_rps = place.latitude_deg
                                 ? base::kEarthRate_rps * std::abs(std::cos(*place.latitude_deg * base::kRadPerDeg))
                                 : base::kEarthRate_rps;
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, line ? kLineColumn + 1 : kLineColumn);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Segment& rest = rests[static_cast<std::size_t>(i)];
    const Vector3& up = ups[static_cast<std::size_t>(i)];
    const double weight = 1.0 / std::hypot(rest.sensor[s].standard_error, unknown_rps / std::sqrt(2.0));
    design(i, 0) = weight;
    for (Eigen::Index j = 0; j < 3; ++j) design(i, kUpColumn + j) = weight * up[static_cast<std::size_t>(j)];
    if (line) design(i, kLineColumn) = weight * (middle_s(rest) - plateau.t_s) / length_s;
    y[i] = weight * (rest.sensor[s].mean - place.earth.vertical_rps * up[axis_of(sensor)]);
  }
  const auto solution = base::solve_orthogonal_with_factor(design, y, 1e-6);
  const Eigen::MatrixXd covariance = solution.factor * solution.factor.transpose();
  const double chi_squared = (y - design * solution.x).squaredNorm();
  const auto freedoms = static_cast<double>(n - solution.rank);
  const bool as_stated = freedoms < 1.0 || chi_squared <= base::chi_squared_quantile(kAttitudeChance, freedoms);
  const double inflation = as_stated ? 1.0 : std::sqrt(chi_squared / freedoms);
  estimate.plateaus = {plateau};
  estimate.plateaus[0].bias = solution.x[0];
  estimate.plateaus[0].bias_se = inflation * std::sqrt(covariance(0, 0));
  estimate.plateaus[0].bias_freedoms = as_stated ? 0.0 : freedoms;
  estimate.reduced_chi_squared = freedoms > 0.0 ? chi_squared / freedoms : 0.0;
  estimate.coupling_freedoms = estimate.plateaus[0].bias_freedoms;
  const double g = place.gravity.mps2 * type.sign_at_rest;
  for (Eigen::Index j = 0; j < 3; ++j) {
    estimate.coupling[static_cast<std::size_t>(j)] = solution.x[kUpColumn + j] / g;
    estimate.coupling_se[static_cast<std::size_t>(j)] =
        inflation * std::sqrt(covariance(kUpColumn + j, kUpColumn + j)) / std::abs(g);
  }
}

void fit_gyros(std::span<const Segment> attitudes, const TriadCalibration& triad, const Place& place,
               const UnitType& type, SixPositionEstimate& result) {
  for (const Sensor sensor : {Sensor::gyro_x, Sensor::gyro_y, Sensor::gyro_z}) {
    std::vector<Segment> rests;
    std::vector<Vector3> ups;
    for (const Segment& segment : attitudes) {
      if (segment.sensor[index_of(sensor)].count == 0) continue;
      const Vector3 up = direction_of_vector(triad.specific_force(means_of(segment, 3)));
      rests.push_back(segment);
      ups.push_back({up[0] * type.sign_at_rest, up[1] * type.sign_at_rest, up[2] * type.sign_at_rest});
    }
    if (rests.size() > kLineColumn) fit_gyro(rests, ups, sensor, place, type, result.sensor[index_of(sensor)]);
  }
}

// Up in each rest, from the accelerometers of an estimate.

/// K and b of the accelerometers; nothing where a bias or a scale error is not known.
struct Accelerometers {
  Eigen::Matrix3d gain = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  bool with_misalignment = true;
};

std::optional<Accelerometers> accelerometers_of(const SixPositionEstimate& estimate) {
  Accelerometers triad;
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorEstimate& sensor = estimate.sensor[3 + i];
    if (sensor.plateaus.size() != 1 || !sensor.plateaus[0].scale_ppm) return std::nullopt;
    const auto row = static_cast<Eigen::Index>(i);
    triad.bias[row] = sensor.plateaus[0].bias;
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) triad.gain(row, static_cast<Eigen::Index>(j)) = sensor.coupling[j].value_or(0.0);
      triad.with_misalignment = triad.with_misalignment && sensor.coupling[j].has_value();
    }
    triad.gain(row, row) = 1.0 + 1e-6 * *sensor.plateaus[0].scale_ppm;
  }
  return triad;
}

std::vector<RestAttitude> attitudes_of(std::span<const Segment> segments, const Accelerometers& triad,
                                       const UnitType& type) {
  const Eigen::Matrix3d inverse = base::inverse(triad.gain);
  std::vector<RestAttitude> rests;
  for (const Segment& segment : segments) {
    if (turns(segment) || !has_triad(segment, 0) || !has_triad(segment, 3)) continue;
    const Vector3 raw = means_of(segment, 3);
    const Eigen::Vector3d force = inverse * (Eigen::Vector3d(raw[0], raw[1], raw[2]) - triad.bias);
    const Eigen::Vector3d up = type.sign_at_rest * force.normalized();
    rests.push_back({segment.t_start_s, segment.t_end_s, {up[0], up[1], up[2]}, means_of(segment, 0)});
  }
  return rests;
}

void warn_of_moves(const GyroGains& gains, std::vector<Warning>& warnings) {
  const std::size_t used = gains.tilts + gains.turns;
  if (gains.saturated > 0) {
    warnings.push_back(
        {"turns_saturated",
         fmt::format(
             "{} movements were left out because a gyro reached the end of its range: move the unit more slowly",
             gains.saturated)});
  }
  if (gains.with_gaps > 0) {
    warnings.push_back({"turns_with_gaps", fmt::format("{} movements were left out because samples are missing in them",
                                                       gains.with_gaps)});
  }
  if (gains.open_turns > 0) {
    warnings.push_back(
        {"turns_without_angle",
         fmt::format("{} turns about the vertical have no angle (or one that the gyros miss by over 20 %) and were not "
                     "used: state it in a column 'turn_deg', or as a constant of the columns map",
                     gains.open_turns)});
  }
  if (used == 0) {
    warnings.push_back({"turns_not_seen",
                        "the movements between the rests do not determine the gyros' scale errors and their "
                        "uncertainty: record the gyros while the unit is turned to nine attitudes or more, or twice "
                        "(each way) through a known angle about each axis ('turn_deg')"});
  }
}

}  // namespace

base::Result<SixPositionEstimate> estimate_attitudes(std::span<const Segment> segments, const Place& place,
                                                     const UnitType& type) {
  std::vector<Segment> attitudes;
  std::vector<AttitudeMean> means;
  for (const Segment& segment : segments) {
    if (!has_triad(segment, 3)) continue;
    attitudes.push_back(segment);
    AttitudeMean mean{means_of(segment, 3), {}};
    for (std::size_t i = 0; i < 3; ++i) mean.standard_error[i] = segment.sensor[3 + i].standard_error;
    means.push_back(mean);
  }
  const auto triad = calibrate_triad(means, place.gravity.mps2);
  if (!triad) return base::forward_error(triad);
  SixPositionEstimate result;
  result.gravity = place.gravity;
  result.no_level_error = "the attitudes are known from the readings alone";
  read_triad(attitudes, *triad, result);
  if (const auto sane = check_scale(result); !sane) return base::forward_error(sane);
  fit_gyros(attitudes, *triad, place, type, result);
  return result;
}

base::Status add_gains(std::span<const Segment> segments, std::span<const Move> moves, const UnitType& type,
                       SixPositionEstimate& estimate) {
  const auto triad = accelerometers_of(estimate);
  if (!triad || moves.empty()) return {};
  const auto gains = estimate_gains(attitudes_of(segments, *triad, type), moves, triad->with_misalignment);
  if (!gains) return base::forward_error(gains);
  warn_of_moves(*gains, estimate.warnings);
  bool all = true;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) all = all && gains->gain_error[i][j].has_value();
  }
  for (std::size_t i = 0; i < 3; ++i) {
    SensorEstimate& gyro = estimate.sensor[i];
    if (gyro.plateaus.size() != 1) continue;
    const auto& scale = gains->gain_error[i][i];
    if (scale && !gyro.plateaus[0].scale_ppm) {
      gyro.plateaus[0].scale_ppm = 1e6 * scale->value;
      gyro.plateaus[0].scale_se_ppm = 1e6 * scale->standard_error;
      gyro.plateaus[0].scale_freedoms = scale->freedoms;
    }
    if (!all) continue;
    gyro.rate_coupling.emplace();
    for (std::size_t j = 0; j < 3; ++j) (*gyro.rate_coupling)[j] = i == j ? Estimate() : *gains->gain_error[i][j];
  }
  return {};
}

}  // namespace soak::calib
