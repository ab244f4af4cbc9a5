// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis::fuzzy {

/// Rows to fit on, and the others to judge by.
struct Split {
  TrainingData fit;
  TrainingData held_out;
};

/// Holds out a share of the groups, drawn by the seed, or where there are fewer than four of them a share of the rows.
/// At least one is held out and one stays. Needs two rows.
[[nodiscard]] Split split(const TrainingData& data, double share, std::uint64_t seed);

/// Weighted squared errors of a model, summed over each group, or where there are fewer than two of them row by row.
/// Where group_variance is positive each group's own weighted mean is taken out of the residuals first, as in
/// shape_rmse().
[[nodiscard]] Eigen::VectorXd unit_errors(const TrainingData& data, const Model& model);

/// How much worse one candidate is than another on the same units: the sum of differences and its standard error.
struct Excess {
  double sum = 0.0;
  double standard_error = 0.0;
};
[[nodiscard]] Excess excess(const Eigen::VectorXd& errors, const Eigen::VectorXd& best);

/// The one-standard-error rule on paired differences: the first candidate (simplest first) whose excess over the best
/// is at most one standard error.
[[nodiscard]] std::size_t simplest_as_good(const std::vector<Eigen::VectorXd>& candidates);

}  // namespace soak::anfis::fuzzy
