// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "anfis/data/training_data.h"
#include "anfis/linear/least_squares.h"
#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// df/d(consequents, premises) of the scaled output at the rows of data.
[[nodiscard]] Eigen::MatrixXd jacobian(const Model& model, const TrainingData& points);

/// What a fit looks like to its parameters: rows and price of curvature (no rows without one), whitened.
struct Linearised {
  Eigen::MatrixXd rows;
  Eigen::MatrixXd price;
};
[[nodiscard]] Linearised linearise(const Model& model, const TrainingData& data, double smoothness,
                                   const GroupWhitening& whitening);

/// Columns of a matrix below this share of the largest are rounding error of a derivative that is zero: unit norm would
/// make them real.
inline constexpr double kZeroColumn = 1e-10;

/// Refuses (bad_input) what no variance of the model on the data can be made of.
[[nodiscard]] base::Status validate_linearisation(const Model& model, const TrainingData& data, double smoothness);

}  // namespace soak::anfis
