// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis::fuzzy {

/// Units in which rows span [-1, 1]. Where y is constant its half range is 1.
struct Scales {
  std::vector<Scale> inputs;
  Scale output;
};
[[nodiscard]] Scales scales_of(const TrainingData& data);

/// Inputs (rows x inputs) and outputs in scaled units.
struct ScaledValues {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
};
[[nodiscard]] ScaledValues scaled_values(const TrainingData& data, const Scales& scales);

/// Training data as clustering sees them.
struct ScaledRows {
  Eigen::MatrixXd x;       ///< rows x inputs, scaled
  Eigen::VectorXd y;       ///< scaled, without the groups' offsets
  Eigen::VectorXd weight;  ///< positive, mean 1
};

/// The offset of a group is the weighted mean of its residuals from one linear model of all rows (generalised least
/// squares), shrunk by group_variance. Free offsets take the level of y with them.
[[nodiscard]] ScaledRows scaled_rows(const TrainingData& data, const Scales& scales);

/// Weighted variance of each column.
[[nodiscard]] Eigen::VectorXd weighted_variances(const Eigen::Ref<const Eigen::MatrixXd>& values,
                                                 const Eigen::VectorXd& weight);

}  // namespace soak::anfis::fuzzy
