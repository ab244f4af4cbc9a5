// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/train/training.h"
#include "base/result.h"

namespace soak::anfis::training {

/// Whether a model can be trained on data: both valid, as many inputs, no fewer distinct rows than consequents.
/// Checking data must have groups where free offsets of the training data leave the level open until the end.
[[nodiscard]] base::Status validate_arguments(const Model& initial, const TrainingData& train, double smoothness,
                                              const TrainingData* checking);

/// Whether a price of curvature is not negative and, where there is one, the curve has one input.
[[nodiscard]] base::Status validate_smoothness(double smoothness, std::size_t inputs);

/// The training, or the refusal where its model is none that can be evaluated or its errors are not finite.
[[nodiscard]] base::Result<Training> usable(Training training);

/// The refusal when not even the first solution is finite.
[[nodiscard]] tl::unexpected<base::Error> unusable_numbers();

}  // namespace soak::anfis::training
