// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calib/gap/ramps/detail/branch_judge.h"
#include "calib/gap/ramps/detail/ramp_mechanisms.h"

namespace soak::calib::gap::reduced {

using Judges = std::array<std::optional<BranchJudge>, kSensorCount>;

/// One mechanism in one sensor, in the shape that predicts its folds best.
struct Outcome {
  std::size_t shape = 0;       ///< index into Mechanism::shapes
  double after = 0.0;          ///< mean square over the folds, SI squared
  double closed = 0.0;         ///< (before − after)/(before − floor) in squares
  bool supported = false;      ///< better in every fold
  double p_adjusted = 1.0;     ///< chance that scatter gains as much, for all shapes and sensors
  double delta_bic = 0.0;      ///< BIC without the term less BIC with it
  std::vector<double> errors;  ///< mean square of each fold
  /// Whether the folds support it, it leaves less than a twentieth of the square, and p_adjusted is below kGate.
  bool explains = false;
};

/// What the folds say of one sensor.
struct SensorFinding {
  double before = 0.0;  ///< mean square over the folds, SI squared
  double floor = 0.0;
  double limit = 0.0;  ///< mean square above the floor from which a gap is seen
  double p_gap = 1.0;  ///< chance that scatter makes such a gap in one of the sensors
  bool gap = false;
  bool repeats = false;           ///< branches of one direction predict each other better than all branches do
  std::vector<Outcome> outcomes;  ///< of each mechanism; empty without a gap
};

/// What the folds say of all.
struct BranchFinding {
  std::array<std::optional<SensorFinding>, kSensorCount> sensor;
  std::optional<std::size_t> winner;  ///< index into the mechanisms
  std::vector<Sensor> explained;      ///< by the winner
  std::vector<Sensor> unexplained;    ///< with a gap
  std::vector<std::size_t> rivals;    ///< mechanisms that the folds cannot tell from the winner
};

/// Mean over the folds, by their judged rows.
[[nodiscard]] double over_folds(const std::vector<double>& squares, const std::vector<double>& weight);

/// A sensor has a gap where the RMS of its left-out blocks is half as large again as their floor, and the chance of
/// that is below kGate for all sensors. The winner is the mechanism that brings the sensors that it explains nearest to
/// their floor; rivals are those that leave no more than six times the winner's square in these sensors, in the
/// geometric mean.
[[nodiscard]] BranchFinding search_branches(const Judges& judges, const std::vector<Mechanism>& mechanisms);

}  // namespace soak::calib::gap::reduced
