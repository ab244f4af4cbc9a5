// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "calib/gap/observations/observations.h"

namespace soak::calib::gap {

/// Readings of one sensor by run and cell (what replicate runs repeat), less what the runs have in common.
class CellMeans {
 public:
  /// `values`: one per observation; NaN = no reading.
  CellMeans(const Observations& observations, const Eigen::VectorXd& values);

  /// How far the curves over temperature of two runs are apart in shape: RMS over the plateaus of their difference. Of
  /// a plateau it is the median over visits and positions, each position freed of its own median before: neither an
  /// offset nor a tilt of the fixture counts, nor a visit that was labelled wrongly. Nothing where they share less than
  /// two plateaus.
  [[nodiscard]] std::optional<double> distance(int run, int other) const;

  /// How readings scatter within runs, as it would show in distance(): from what visits of one run to the same plateau
  /// differ by (effects of the past too), all runs together, and a block's repeatability in its placement. With less
  /// than four plateaus that a run visited twice, four times that repeatability at least.
  [[nodiscard]] double scatter() const;

 private:
  struct Cell {
    int level = 0;
    int position = -1;
  };

  std::vector<Cell> cells_;
  std::vector<std::vector<double>> means_;  ///< of run and cell, NaN where there is none
  int levels_ = 0;
  double block_variance_ = 0.0;
};

}  // namespace soak::calib::gap
