// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calib/gap/ramps/detail/branch_fit.h"

namespace soak::calib::gap::ramps {

/// An effect that follows time, temperature or a logged channel, as it shows on ramps.
struct RampEffect {
  const Effect* effect = nullptr;
  OnRamps shown = {};
  bool nuisance = false;  ///< never named: forbids names where it does as well

  [[nodiscard]] const std::vector<Candidate>& candidates() const { return shown.candidates; }
};

/// The effects of the library whose channels were recorded, and a straight drift in time as nuisance, in the order in
/// which rivals are listed. `halves`: of two branches, without candidates of two parameters.
[[nodiscard]] std::vector<RampEffect> effects_on_ramps(const RampRecording& recording,
                                                       const TemperatureHistory& history, bool halves);

using BranchFits = std::array<std::optional<BranchFit>, kSensorCount>;

/// One effect in one sensor, in the candidate that predicts its folds best.
struct Outcome {
  std::size_t candidate = 0;   ///< index into RampEffect::candidates()
  double after = 0.0;          ///< mean square over the folds, SI squared
  double closed = 0.0;         ///< (before − after)/(before − floor) in squares
  bool supported = false;      ///< better in every fold
  double p_adjusted = 1.0;     ///< chance that scatter gains as much, for all candidates and sensors
  double delta_bic = 0.0;      ///< BIC without the term less BIC with it
  std::vector<double> errors;  ///< mean square of each fold
  /// Whether the folds support it, it leaves less than a twentieth of the square, and p_adjusted is below kGate; of two
  /// branches also, whether a straight drift leaves four times its square.
  bool explains = false;
};

/// What the folds say of one sensor.
struct SensorResult {
  double before = 0.0;  ///< mean square over the folds, SI squared
  double floor = 0.0;
  double limit = 0.0;  ///< mean square above the floor from which a gap is seen
  double p_gap = 1.0;  ///< chance that scatter makes such a gap in one of the sensors
  bool gap = false;
  bool repeats = false;           ///< branches of one direction predict each other better than all branches do
  std::vector<Outcome> outcomes;  ///< of each effect; empty without a gap
};

/// What the folds say of all.
struct BranchResult {
  std::array<std::optional<SensorResult>, kSensorCount> sensor;
  std::optional<std::size_t> winner;  ///< index into the effects
  std::vector<Sensor> explained;      ///< by the winner
  std::vector<Sensor> unexplained;    ///< with a gap
  std::vector<std::size_t> rivals;    ///< effects that the folds cannot tell from the winner
};

/// Mean over the folds, by their judged rows.
[[nodiscard]] double over_folds(const std::vector<double>& squares, const std::vector<double>& weight);

/// A sensor has a gap where the RMS of its predicted blocks is half as large again as their floor, and the chance of
/// that is below kGate for all sensors. The winner is the effect that brings the sensors that it explains nearest to
/// their floor; rivals are those that leave no more than six times the winner's square in these sensors, in the
/// geometric mean.
[[nodiscard]] BranchResult search_branches(const BranchFits& fits, const std::vector<RampEffect>& effects, bool halves);

}  // namespace soak::calib::gap::ramps
