// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/gap/noise/noise_components.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Turns the rows of one sensor into rows of unit variance that do not correlate, under nested noise: one Cholesky
/// factor per visit. Rows without a value, and those whose `keep` is false, are left out.
class Whitening {
 public:
  Whitening(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
            const std::vector<bool>& keep);

  /// Whitened rows of `columns`, which has one row per observation.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const;
  /// Observation that whitened row i belongs to: rows keep their visit and run.
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return rows_; }

 private:
  struct Visit {
    Eigen::Index first;  ///< index into rows_
    Eigen::MatrixXd factor;
  };
  std::vector<Eigen::Index> rows_;
  std::vector<Visit> visits_;
};

}  // namespace soak::calib::gap
