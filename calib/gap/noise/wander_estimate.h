// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "calib/gap/noise/noise.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Estimates how a bias wanders while units run (bias instability, rate random walk) from what differs between runs:
/// variances of Gauss-Markov processes of fixed correlation times, from five minutes to two days, beside those of
/// placements and visits. Minimum norm quadratic estimates (MINQUE, C. R. Rao 1971), none negative, on means over the
/// placements that another run repeats, with free means of runs and of what they repeat; the weights are those of a
/// bias that wanders as much as placements scatter.
class WanderEstimate {
 public:
  /// `observations` must outlive this. `residual`: of one sensor, NaN where it has no reading. `nuisances`: further
  /// columns of free strength that are no noise (the time of day), a row for each observation. Cost: for each run the
  /// cube of the number of its placements, some tens of times.
  WanderEstimate(const Observations& observations, const Eigen::VectorXd& residual, const Eigen::MatrixXd& nuisances);
  WanderEstimate(WanderEstimate&&) noexcept;
  WanderEstimate& operator=(WanderEstimate&&) noexcept;
  ~WanderEstimate();

  /// Whether another sensor has readings in the same rows, so that it can be estimated as well.
  [[nodiscard]] bool is_for(const Eigen::VectorXd& residual) const;

  /// `nested` with its scatter of placements and visits shared out anew; nothing where runs repeat too little to tell.
  [[nodiscard]] std::optional<NoiseComponents> of(const Eigen::VectorXd& residual, NoiseComponents nested) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib::gap
