// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// Rows to learn from: inputs, one output, what each row weighs and which random offset it shares.
struct TrainingData {
  std::vector<double> x;        ///< the inputs of one row after the other
  std::vector<double> y;        ///< one per row
  std::vector<double> weight;   ///< 1/variance of each row, or empty: 1 everywhere
  std::vector<int> group;       ///< group (run) of each row, or empty: no groups
  double group_variance = 0.0;  ///< variance of the groups' offsets in the units of 1/weight; +infinity: fixed effects

  std::size_t inputs = 1;  ///< number of inputs, at least 1

  [[nodiscard]] std::size_t rows() const { return x.size() / inputs; }
  [[nodiscard]] std::span<const double> row(std::size_t index) const {
    return std::span(x).subspan(index * inputs, inputs);
  }
};

/// Whether sizes agree, x and y are finite and at most 1e100, weights 1e-100..1e100, group_variance >= 0 with groups
/// wherever it is positive, no input is constant, and there are at least `parameters` distinct rows of x. The message
/// says what to change.
[[nodiscard]] base::Status validate(const TrainingData& data, std::size_t parameters);

/// Number of distinct rows of x.
[[nodiscard]] std::size_t distinct_inputs(const TrainingData& data);

/// The rows for which keep is true.
[[nodiscard]] TrainingData select_rows(const TrainingData& data, const std::vector<bool>& keep);

/// y minus the model's output, row by row.
[[nodiscard]] std::vector<double> residuals(const TrainingData& data, const Model& model);

/// RMSE of residuals (one per row of data), sqrt(sum w r^2 / sum w). Where group_variance is positive each group's own
/// weighted mean is taken out first: the error of the shape, which no group's offset touches.
[[nodiscard]] double shape_rmse(const TrainingData& data, std::vector<double> residuals);

/// The same for the residuals of a model.
[[nodiscard]] double shape_rmse(const TrainingData& data, const Model& model);

}  // namespace soak::anfis
