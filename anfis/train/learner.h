// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>

#include "anfis/train/hybrid_learning.h"
#include "anfis/train/variable_projection.h"

namespace soak::anfis {

/// A way to learn with its options. Variable projection unless the user says otherwise: it recovers known systems to
/// rounding where hybrid learning stays a thousandth off, and its thermal curves are the best of bench/. From a single
/// start on noise-free data of several inputs 500 epochs of hybrid learning can end lower: give it more starts.
using Learner = std::variant<VariableProjectionOptions, HybridOptions>;

/// Trains with one or the other: train_variable_projection() or train_hybrid().
[[nodiscard]] inline base::Result<Training> train(const Model& initial, const TrainingData& data,
                                                  const Learner& learner, const TrainingData* checking = nullptr) {
  if (const auto* hybrid = std::get_if<HybridOptions>(&learner)) return train_hybrid(initial, data, *hybrid, checking);
  return train_variable_projection(initial, data, std::get<VariableProjectionOptions>(learner), checking);
}

}  // namespace soak::anfis
