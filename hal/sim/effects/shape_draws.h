// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.h"
#include "hal/sim/config/range.h"

namespace soak::hal::sim {

/// One number that gives a mechanism its shape, as it was drawn; the name carries the unit.
struct ShapeParameter {
  std::string name;
  double value = 0.0;
};

/// Draws the shape of a mechanism and remembers it for the truth.
class ShapeDraws {
 public:
  explicit ShapeDraws(base::Random random) : random_(random) {}

  /// Uniform in `range`.
  [[nodiscard]] double within(std::string_view name, Range range) {
    return kept(name, random_.uniform(range.low, range.high));
  }
  /// As within(), the logarithm uniform: for time constants.
  [[nodiscard]] double spread(std::string_view name, Range range) {
    return kept(name, range.low * std::pow(range.high / range.low, random_.uniform()));
  }
  /// True with probability one half; 1 or 0 in the truth.
  [[nodiscard]] bool toss(std::string_view name) { return kept(name, random_.uniform() < 0.5 ? 1.0 : 0.0) > 0.5; }
  /// Remembers a number that was not drawn here.
  double kept(std::string_view name, double value) {
    parameters_.push_back({std::string(name), value});
    return value;
  }
  /// For what needs many numbers that no truth lists.
  [[nodiscard]] base::Random& random() { return random_; }
  [[nodiscard]] const std::vector<ShapeParameter>& parameters() const { return parameters_; }

 private:
  base::Random random_;
  std::vector<ShapeParameter> parameters_;
};

}  // namespace soak::hal::sim
