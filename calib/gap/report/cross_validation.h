// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// The gap of one sensor on runs that neither base nor terms saw, SI.
struct SensorGap {
  double before_rms = 0.0;                ///< of the blocks about the base, each run's own offset taken off
  double after_rms = 0.0;                 ///< with the terms
  double floor_rms = 0.0;                 ///< what noise and the scatter of the training runs alone would leave
  std::optional<double> closed_fraction;  ///< (before − after)/(before − floor)
  std::optional<std::pair<double, double>> closed_ci95;  ///< t interval over the runs
};

using SensorGaps = std::array<std::optional<SensorGap>, kSensorCount>;

/// Mean square of values in one run about their own mean; nothing where fewer than two are numbers.
[[nodiscard]] std::optional<double> mean_square(const Observations& observations, const Eigen::VectorXd& values,
                                                int run);

/// Cross-validation, one run after the other: base, shapes and parameters of `effects` from the others, judged on that
/// run. Which effects act on which sensors was chosen on all runs. The fraction (of means over the runs of their own
/// RMS) is absent where before − floor is under two standard errors, and where no effect could close it: those outside
/// the mean, and those that are drawn anew with each mounting. `noise`: of all runs, where it is not to be estimated
/// from the others. Cost: as many fits of the campaign as there are runs.
[[nodiscard]] SensorGaps cross_validated_gap(const Observations& observations, const TemperatureHistory& history,
                                             const std::vector<NamedEffect>& effects,
                                             const std::optional<KnownNoise>& noise = {});

/// The same of one run that was locked away before the search, a single number: base, shapes and parameters from all
/// others. Its fraction has no interval; it is absent where no effect could close the gap, or nothing is above the
/// floor. `noise`: as above.
[[nodiscard]] SensorGaps gap_of_unseen_run(const Observations& observations, const TemperatureHistory& history,
                                           const std::vector<NamedEffect>& effects, int run,
                                           const std::optional<KnownNoise>& noise = {});

}  // namespace soak::calib::gap
