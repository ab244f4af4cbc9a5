// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/noise/noise.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Estimates how a bias wanders while units run (bias instability, rate random walk) from what differs between runs:
/// variances of Gauss-Markov processes of fixed correlation times, from five minutes to two days, beside those of
/// placements and visits, on means over placements, with free means of runs and of what runs repeat. Minimum norm
/// quadratic estimates (MINQUE, C. R. Rao 1971) none of which is negative; weights are those of a bias that wanders as
/// much as placements scatter.
class WanderEstimate {
 public:
  /// `residual`: of one sensor, NaN where it has no reading; another residual may be estimated from if it has readings
  /// in the same rows. Cost: the cube of the number of placements in a run, times the square of the number of runs.
  WanderEstimate(const Observations& observations, const Eigen::VectorXd& residual);

  /// Whether a residual has readings where this one had.
  [[nodiscard]] bool is_for(const Observations& observations, const Eigen::VectorXd& residual) const;

  /// `nested` with its scatter of placements and visits shared out between these and the wander. Unchanged where runs
  /// repeat too little to tell.
  [[nodiscard]] NoiseComponents estimate(const Observations& observations, const Eigen::VectorXd& residual,
                                         NoiseComponents nested) const;

 private:
  std::vector<Stay> places_;              ///< placements that runs repeat, without their values
  std::vector<Eigen::MatrixXd> kernels_;  ///< per component the blocks of the runs, one under the other
  std::vector<Eigen::Index> run_first_;   ///< first place of each run, and their number
  Eigen::MatrixXd weight_;                ///< inverse covariance freed of the means
  Eigen::MatrixXd information_;           ///< of the components
  double blocks_ = 1.0;                   ///< mean number of a placement's blocks
};

}  // namespace soak::calib::gap
