// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/effects/effect.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {

/// Sensors of a campaign with base and accepted terms taken off; a sensor that was not recorded has none.
struct Residuals {
  std::array<std::optional<SensorResidual>, kSensorCount> sensor;
  std::array<NoiseComponents, kSensorCount> noise;
  std::vector<int> run_fold;    ///< of each observation
  std::vector<int> level_fold;  ///< likewise
  int runs = 0;
  int levels = 0;
};

/// One candidate against the residuals.
struct CandidateTest {
  std::array<std::optional<TermTest>, kSensorCount> sensor;  ///< each on its own, also of a shared term
  std::optional<TermTest> shared;                            ///< of all sensors with one set of parameters
};

[[nodiscard]] CandidateTest test_candidate(const Residuals& residuals, const Candidate& candidate);

/// How well a candidate stands: what search and verdict compare.
struct Standing {
  double p = 1.0;               ///< of its best set of sensors, adjusted for the choice among the sets
  double merit = 0.0;           ///< gain over heterogeneity less the price of its parameters, over the sensors it helps
  double gain = 0.0;            ///< the same without the price
  std::vector<Sensor> sensors;  ///< that it helps, each by itself
  int supporting_folds = 0;
  int judged_folds = 0;
  double gain_beside_best_fold = 0.0;
};

/// Whether parameters from the other folds make half of the folds better, of at least two, and the sum of all
/// even without the one that gains most.
[[nodiscard]] bool enough_folds(const Standing& standing);

/// `typical`: median heterogeneity of the library. `price`: of one parameter, in units of the whitened gain; a free
/// number in the shape costs one more.
[[nodiscard]] Standing standing(const CandidateTest& test, const Candidate& candidate, double typical, double price);

}  // namespace soak::calib::gap
