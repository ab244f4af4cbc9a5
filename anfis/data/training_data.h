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

  /// Of rows that stand for others each (linear/condensed_rows.h), else empty: upper triangular R, rows x rows, column
  /// by column, with V^-1 = R^T R. `group` is empty then, as the groups' offsets are in R.
  std::vector<double> precision_factor;
  double squares_within = 0.0;  ///< part of r^T V^-1 r that is in no condensed row
  std::size_t rows_behind = 0;  ///< number of rows that the condensed ones stand for

  [[nodiscard]] std::size_t rows() const { return x.size() / inputs; }
  /// Number of rows that were measured.
  [[nodiscard]] std::size_t measured_rows() const { return precision_factor.empty() ? rows() : rows_behind; }
  [[nodiscard]] std::span<const double> row(std::size_t index) const {
    return std::span(x).subspan(index * inputs, inputs);
  }
};

/// Whether sizes agree, x and y are finite and at most 1e100, weights 1e-100..1e100, group_variance >= 0 with groups
/// wherever it is positive, no input is constant, there are at least `parameters` distinct rows of x, and condensed
/// rows are whole and have no groups beside their factor. The message says what to change.
[[nodiscard]] base::Status validate(const TrainingData& data, std::size_t parameters);

/// Number of distinct rows of x.
[[nodiscard]] std::size_t distinct_inputs(const TrainingData& data);

/// The rows for which keep is true; not of condensed rows, which are tied together by their factor.
[[nodiscard]] TrainingData select_rows(const TrainingData& data, const std::vector<bool>& keep);

/// y minus the model's output, row by row.
[[nodiscard]] std::vector<double> residuals(const TrainingData& data, const Model& model);

/// RMSE of residuals (one per row of data), sqrt(sum w r^2 / sum w). Where group_variance is positive each group's own
/// weighted mean is taken out first: the error of the shape, which no group's offset touches.
[[nodiscard]] double shape_rmse(const TrainingData& data, std::vector<double> residuals);

/// The same for the residuals of a model.
[[nodiscard]] double shape_rmse(const TrainingData& data, const Model& model);

}  // namespace soak::anfis
