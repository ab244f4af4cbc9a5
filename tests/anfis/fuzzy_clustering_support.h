// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/select/detail/gath_geva.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/random.h"

// Data with known clusters, and how clusterings compare.
namespace soak::anfis::clustering_support {

/// Two inputs, smooth, with weights.
inline TrainingData smooth_surface(std::uint64_t seed, int rows) {
  TrainingData data;
  data.inputs = 2;
  base::Random random(seed);
  for (int k = 0; k < rows; ++k) {
    const double a = random.uniform(-2.0, 5.0);
    const double b = random.uniform(10.0, 11.0);
    data.x.insert(data.x.end(), {a, b});
    data.y.push_back(std::sin(a) * b + 0.3 * random.gaussian());
    data.weight.push_back(random.uniform(0.2, 3.0));
  }
  return data;
}

}  // namespace soak::anfis::clustering_support
