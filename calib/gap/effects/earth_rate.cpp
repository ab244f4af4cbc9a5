// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/effects/list.h"

namespace soak::calib::gap {
namespace {

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The body axis that follows, cyclically, the one nearest to the vertical, made horizontal.
Vector3 reference_axis(const Vector3& up) {
  std::size_t vertical = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (std::abs(up[axis]) > std::abs(up[vertical])) vertical = axis;
  }
  Vector3 forward{};
  forward[(vertical + 1) % 3] = 1.0;
  const double along = forward[0] * up[0] + forward[1] * up[1] + forward[2] * up[2];
  for (std::size_t axis = 0; axis < 3; ++axis) forward[axis] -= along * up[axis];
  const double norm = std::hypot(forward[0], forward[1], forward[2]);
  for (double& component : forward) component /= norm;
  return forward;
}

/// Vertical part, and the two horizontal ones along the reference axis and across it, for one heading of all positions.
std::vector<Candidate> candidates(const Circumstances& c) {
  Candidate candidate{.shared = true};
  const auto n = static_cast<Eigen::Index>(c.observations.rows.size());
  for (std::size_t gyro = 0; gyro < 3; ++gyro) candidate.columns[gyro] = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3& up = c.observations.rows[static_cast<std::size_t>(i)].up;
    if (std::hypot(up[0], up[1], up[2]) < 0.5) continue;
    const Vector3 forward = reference_axis(up);
    const Vector3 side = cross(up, forward);
    for (std::size_t gyro = 0; gyro < 3; ++gyro) {
      candidate.columns[gyro].row(i) << up[gyro], forward[gyro], side[gyro];
    }
  }
  return {candidate};
}

/// The whole vector is the rotation of the Earth, within its error; with the vertical part taken off before, or hidden
/// from gyros of one axis, it can only be less.
bool plausible(const Candidate&, const Eigen::VectorXd& theta, const Eigen::MatrixXd& covariance) {
  constexpr double kSigmas = 4.0;
  const double error = std::sqrt(std::max(0.0, covariance.trace()));
  return theta.norm() < 1.1 * base::kEarthRate_rps + kSigmas * error;
}

}  // namespace

Effect earth_rate() {
  Effect effect;
  effect.name = "earth_rate";
  effect.physics =
      "the gyros feel the rotation of the Earth, the same size on all of them; its vertical part is known "
      "where the latitude is";
  effect.twins = {"g_sensitivity"};
  effect.experiment = "the same positions with the fixture turned in azimuth; a known latitude for the vertical part";
  effect.missing = [](const Circumstances& c) -> std::optional<std::string> {
    if (!c.observations.has_positions()) return "one attitude only";
    return std::nullopt;
  };
  effect.candidates = candidates;
  effect.plausible = plausible;
  effect.magnitude = [](const Circumstances&, const Candidate&, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() * base::kDegPerRad, "deg/s"};
  };
  return effect;
}

}  // namespace soak::calib::gap
