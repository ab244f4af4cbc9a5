// SPDX-License-Identifier: Apache-2.0
#include "ten_inputs.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/random.h"

namespace soak::anfis::test {
namespace {

TrainingData friedman_rows(std::uint64_t seed, int rows) {
  TrainingData data;
  data.inputs = 10;
  base::Random random(seed);
  for (int k = 0; k < rows; ++k) {
    for (int j = 0; j < 10; ++j) data.x.push_back(random.uniform());
    const auto x = data.row(data.rows() - 1);
    data.y.push_back(10.0 * std::sin(std::numbers::pi * x[0] * x[1]) + 20.0 * std::pow(x[2] - 0.5, 2) + 10.0 * x[3] +
                     5.0 * x[4] + random.gaussian());
  }
  return data;
}

TrainingData saturation_rows(std::uint64_t seed, int rows) {
  TrainingData data;
  data.inputs = 10;
  base::Random random(seed);
  for (int k = 0; k < rows; ++k) {
    const double common = random.gaussian();
    for (int j = 0; j < 10; ++j) data.x.push_back(std::tanh(0.7 * (0.6 * common + 0.8 * random.gaussian())));
    const auto x = data.row(data.rows() - 1);
    data.y.push_back(2.0 * std::tanh(2.5 * x[0]) * x[3] + std::sin(2.5 * x[5]) + 1.5 * x[7] * x[7] + 0.8 * x[8] +
                     0.05 * x[1] + 0.3 * random.gaussian());
  }
  return data;
}

}  // namespace

TenInputs friedman() { return {friedman_rows(1, 2000), friedman_rows(2, 4000), 1.0}; }

TenInputs saturations() { return {saturation_rows(1, 3000), saturation_rows(2, 4000), 0.3}; }

}  // namespace soak::anfis::test
