// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "anfis/model/model.h"
#include "base/result.h"

namespace soak::anfis {

/// A rule of a curve y(x): its own membership, bell or Gaussian, and its consequent in one place, in scaled units.
struct CurveRule {
  double width = 1.0;   ///< a of the bell, standard deviation of the Gaussian
  double slope = 0.0;   ///< b of the bell; 0 for the Gaussian
  double centre = 0.0;  ///< where the membership is 1
  double gain = 0.0;
  double offset = 0.0;

  friend bool operator==(const CurveRule&, const CurveRule&) = default;
};

/// Model of one input with these rules, scales 1 and valid range 0 (set them). shape: bell or gaussian.
[[nodiscard]] Model curve_model(Shape shape, std::span<const CurveRule> rules);

/// Whether a valid model is such a curve: one input, one kind of membership, bell or Gaussian, and one membership per
/// rule. The message says what is not so.
[[nodiscard]] base::Status validate_curve(const Model& model);

/// Shape of the memberships of such a curve.
[[nodiscard]] Shape curve_shape(const Model& model);

/// Rule by rule. For models that validate_curve() accepts.
[[nodiscard]] std::vector<CurveRule> curve_rules(const Model& model);

}  // namespace soak::anfis
