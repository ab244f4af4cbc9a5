// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "calib/estimate/site.h"
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// Vertical part, and the horizontal one to north and to east: of the heading that the positions have on the fixture, 0
/// where that is not known.
std::vector<Candidate> earth_rate_candidates(const RegressorInputs& in) {
  Candidate candidate{.shared = true};
  const auto n = static_cast<Eigen::Index>(in.observations.rows.size());
  for (std::size_t gyro = 0; gyro < 3; ++gyro) candidate.columns[gyro] = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int position = in.observations.rows[static_cast<std::size_t>(i)].position;
    if (position < 0) continue;
    const Frame frame = frame_of(in.observations.positions[static_cast<std::size_t>(position)], 0.0);
    for (std::size_t gyro = 0; gyro < 3; ++gyro) {
      candidate.columns[gyro].row(i) << frame.up[gyro], frame.north[gyro], frame.east[gyro];
    }
  }
  return {std::move(candidate)};
}

/// The whole vector is the rotation of the Earth, within its error; hidden from gyros of one axis, it can only be less.
/// Where its vertical part was taken off by a known latitude, twice as much of that is left if the latitude had the
/// wrong sign.
bool can_be_earth_rate(const RegressorInputs& in, const Candidate&, const Eigen::VectorXd& theta,
                       const Eigen::MatrixXd& covariance) {
  constexpr double kSigmas = 4.0;
  const double error = std::sqrt(std::max(0.0, covariance.trace()));
  const double most = 1.1 * base::kEarthRate_rps + kSigmas * error;
  const double horizontal = theta.tail<2>().norm();
  if (in.observations.earth_taken_off) return horizontal < most && std::abs(theta(0)) < 2.0 * most;
  return theta.norm() < most;
}

}  // namespace

Effect earth_rate() {
  Effect effect;
  effect.name = "earth_rate";
  effect.physics =
      "the gyros feel the rotation of the Earth, the same size on all of them; its vertical part is known where the "
      "latitude is";
  effect.twins = {"g_sensitivity"};
  effect.experiment = "the same positions with the fixture turned in azimuth; a known latitude for the vertical part";
  effect.missing = one_attitude_only;
  effect.candidates = earth_rate_candidates;
  effect.plausible = can_be_earth_rate;
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() * base::kDegPerRad, "deg/s"};
  };
  effect.meaning = [](const RegressorInputs&, const Candidate&, Sensor) {
    return Meaning{{{"up", "rad/s"}, {"north", "rad/s"}, {"east", "rad/s"}}, {}};
  };
  return effect;
}

}  // namespace soak::calib::gap
