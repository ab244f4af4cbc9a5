// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis::test {

/// A model of two inputs with random premises and consequents, and rows around it.
struct Sample {
  std::string what;  ///< for messages
  Model model;
  TrainingData data;
};

/// 37 random rows (no multiple of a kernel's lanes) of two inputs that span [10, 30] and [-2, 0], y random.
TrainingData random_rows(std::uint64_t seed);

/// Grid of 3 x 2 memberships that rules share. Every row fires.
Sample grid_sample(Shape shape, TNorm t_norm, int order);

/// Four rules with memberships of their own, two of which ask about one input only, and in order 1 dropped gains. Every
/// row fires.
Sample scatter_sample(Shape shape, TNorm t_norm, int order);

/// Both kinds for every shape, T-norm and order: 40 of them.
std::vector<Sample> all_samples();

}  // namespace soak::anfis::test
