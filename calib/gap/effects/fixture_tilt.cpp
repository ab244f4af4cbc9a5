// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "base/units.h"
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// A small rotation of the unit on its fixture, three angles per run but the first: what all runs share is
/// misalignment. f becomes f + f × angle.
std::vector<Candidate> fixture_tilt_candidates(const RegressorInputs& in) {
  const auto n = static_cast<Eigen::Index>(in.observations.rows.size());
  const Eigen::Index mountings = in.observations.run_count() - 1;
  Candidate candidate{.shared = true, .folds = Folds::levels};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, 3 * mountings);
    const auto next = (axis + 1) % 3;
    const auto last = (axis + 2) % 3;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Observation& row = in.observations.rows[static_cast<std::size_t>(i)];
      if (row.run == 0) continue;
      const Eigen::Index first = 3 * (row.run - 1);
      const double g = in.observations.gravity_mps2;
      columns(i, first + static_cast<Eigen::Index>(last)) = g * in.observations.force_g(row, next);
      columns(i, first + static_cast<Eigen::Index>(next)) = -g * in.observations.force_g(row, last);
    }
    candidate.columns[axis + 3] = columns;
  }
  return {std::move(candidate)};
}

}  // namespace

Effect fixture_tilt() {
  Effect effect;
  effect.name = "fixture_tilt";
  effect.physics =
      "each mounting sets the unit a little askew: one small rotation for all sensors, constant over temperature, "
      "different in the next run";
  effect.twins = {"cross_axis"};
  effect.experiment = "the unit taken out and mounted again between two runs";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (!in.observations.has_positions()) return "one attitude only";
    if (in.observations.run_count() < 2) return "one run only: a constant tilt is misalignment";
    if (in.observations.level_count() < 3) return "fewer than three temperatures";
    return std::nullopt;
  };
  effect.candidates = fixture_tilt_candidates;
  effect.magnitude = [](const RegressorInputs& in, const Candidate&, Sensor, const Eigen::VectorXd& theta) {
    // Root mean square angle of the runs about their mean, that of the first run being 0 by convention.
    const Eigen::Index runs = in.observations.run_count();
    Eigen::MatrixXd angles = Eigen::MatrixXd::Zero(3, runs);
    angles.rightCols(runs - 1) = theta.reshaped(3, runs - 1);
    angles.colwise() -= angles.rowwise().mean().eval();
    return Magnitude{std::sqrt(angles.squaredNorm() / static_cast<double>(runs - 1)) * base::kDegPerRad, "deg"};
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate&, Sensor) {
    Meaning meaning;
    for (std::size_t run = 0; run < in.observations.run_ids.size(); ++run) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string name = axis_name(axis) + "@" + in.observations.run_ids[run];
        if (run == 0) {
          meaning.given.push_back({name, 0.0, "rad"});
        } else {
          meaning.estimated.push_back({name, "rad"});
        }
      }
    }
    return meaning;
  };
  return effect;
}

}  // namespace soak::calib::gap
