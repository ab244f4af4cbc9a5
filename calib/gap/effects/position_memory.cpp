// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

/// A memory that holds the placement before for as long as the unit rests.
constexpr double kStays_s = 1e6;

Eigen::RowVector3d force_g(const Observations& observations, const Observation& row) {
  return {observations.force_g(row, 0), observations.force_g(row, 1), observations.force_g(row, 2)};
}

/// What a first-order memory of the specific force still holds beyond that of now, g: it follows the force of each
/// placement with the time constant, and is at rest in the first of a run.
Eigen::MatrixX3d fading(const Observations& observations, double tau_s) {
  const auto n = static_cast<Eigen::Index>(observations.rows.size());
  Eigen::MatrixX3d beyond = Eigen::MatrixX3d::Zero(n, 3);
  Eigen::RowVector3d kept = Eigen::RowVector3d::Zero();  // the memory when the placement began
  double began_s = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const Observation* before = i > 0 ? &observations.rows[static_cast<std::size_t>(i - 1)] : nullptr;
    const Eigen::RowVector3d now = force_g(observations, row);
    if (before == nullptr || before->run != row.run) {
      kept = now;
    } else if (before->placement != row.placement) {
      const Eigen::RowVector3d then = force_g(observations, *before);
      kept = then + (kept - then) * std::exp(-(row.t_s - row.t_in_placement_s - began_s) / tau_s);
    }
    began_s = row.t_s - row.t_in_placement_s;
    beyond.row(i) = (kept - now) * std::exp(-row.t_in_placement_s / tau_s);
  }
  return beyond;
}

/// The force of the placement before, g; nothing in the first of a run.
Eigen::MatrixX3d staying(const Observations& observations) {
  Eigen::MatrixX3d before = Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(observations.rows.size()), 3);
  for (Eigen::Index i = 0; i < before.rows(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    if (row.previous < 0) continue;
    const Vector3& up = observations.positions[static_cast<std::size_t>(row.previous)].up;
    before.row(i) = observations.sign_at_rest * Eigen::RowVector3d(up[0], up[1], up[2]);
  }
  return before;
}

/// None between what fades within hours and what stays: it would be the position at the start of the run.
std::vector<Candidate> fading_in(const RegressorInputs& in, double tau_s) {
  constexpr double kSlowest_s = 1e4;
  if (tau_s > kSlowest_s && tau_s < kStays_s) return {};
  if (tau_s >= kStays_s) return {for_all("does not fade", {kStays_s}, staying(in.observations))};
  return {for_all(fmt::format("tau {:.3g} s", tau_s), {tau_s}, fading(in.observations, tau_s))};
}

}  // namespace

Effect position_memory() {
  Effect effect;
  effect.name = "position_memory";
  effect.physics =
      "stress from the weight of parts, gels and mounts creeps: a sensor still feels the position before, and less of "
      "it with time";
  effect.twins = {"g_sensitivity", "earth_rate"};
  effect.experiment = "the same positions in another order, and one that is held for an hour";
  effect.missing = [](const RegressorInputs& in) -> std::optional<std::string> {
    if (auto one = one_attitude_only(in)) return one;
    return in.history.coarse();
  };
  effect.candidates = [](const RegressorInputs& in) {
    return over_grid(in, std::array{60.0, 120.0, 240.0, 480.0, 960.0, kStays_s}, fading_in);
  };
  effect.of_shape = fading_in;
  effect.magnitude = [](const RegressorInputs&, const Candidate&, Sensor sensor, const Eigen::VectorXd& theta) {
    return Magnitude{theta.norm() * printed_per_si(sensor), std::string(printed_unit(sensor)) + "/g"};
  };
  effect.meaning = [](const RegressorInputs& in, const Candidate& candidate, Sensor sensor) {
    Meaning meaning;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      meaning.estimated.push_back(
          {axis_name(axis), "(" + si_unit(sensor) + ")/(m/s2)", 1.0 / in.observations.gravity_mps2});
    }
    meaning.given.push_back({"tau_s", candidate.shape_values.front(), "s"});
    return meaning;
  };
  return effect;
}

}  // namespace soak::calib::gap
