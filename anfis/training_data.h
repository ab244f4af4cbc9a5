// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "base/result.h"

namespace soak::anfis {

/// Rows to learn from: one input, one output, what each row weighs and which random offset it shares.
struct TrainingData {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> weight;   ///< 1/variance of each row, or empty: 1 everywhere
  std::vector<int> group;       ///< group (run) of each row, or empty: no groups
  double group_variance = 0.0;  ///< variance of the groups' offsets in the units of 1/weight; +infinity: fixed effects

  [[nodiscard]] std::size_t rows() const { return x.size(); }
};

/// Whether sizes agree, x and y are finite, weights positive and finite, group_variance >= 0 with groups wherever it is
/// positive, x is not constant, and x has at least `parameters` distinct values. The message says what to change.
[[nodiscard]] base::Status validate(const TrainingData& data, std::size_t parameters);

/// Number of distinct values of x.
[[nodiscard]] std::size_t distinct_inputs(const TrainingData& data);

/// The rows for which keep is true.
[[nodiscard]] TrainingData select_rows(const TrainingData& data, const std::vector<bool>& keep);

/// RMSE of residuals (output minus prediction, one per row of data), sqrt(sum w r^2 / sum w). Where group_variance is
/// positive each group's own weighted mean is taken out first: the error of the shape, which no group's offset touches.
[[nodiscard]] double shape_rmse(const TrainingData& data, std::vector<double> residuals);

}  // namespace soak::anfis
