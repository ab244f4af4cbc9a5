// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/data/training_data.h"

namespace soak::anfis::test {

/// A problem of ten inputs: five sets each would be 5^10 = 9,765,625 grid rules [AH05 §5.3.3].
struct TenInputs {
  TrainingData train;
  TrainingData test;  ///< other rows of the same truth, with the same noise
  double noise;       ///< standard deviation: no model is better than that on the test rows
};

/// Friedman's function (1991, MARS): ten independent uniform inputs, five of them idle, noise 1 beside a spread of 4.9.
TenInputs friedman();

/// Ten inputs that share a common part (correlation about 0.35): a saturation times another input, a sine, a square, a
/// line, one that hardly matters; four idle ones. Noise 0.3 beside a spread of 1.6.
TenInputs saturations();

}  // namespace soak::anfis::test
