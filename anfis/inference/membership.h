// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>

#include "anfis/model.h"

namespace soak::anfis::inference {

/// How far the scaled input u lies from the centre of a rule, in the form that its membership takes it:
/// ln((u - centre)/width)^2 for the bell, ((u - centre)/width)^2 for the Gaussian.
inline double distance_measure(Membership membership, const Rule& rule, double u) {
  const double t = (u - rule.centre) / rule.width;
  return membership == Membership::bell ? std::log(t * t) : t * t;
}

/// Degree of membership for a distance measure: 0..1.
inline double membership_degree(Membership membership, const Rule& rule, double distance) {
  // [AH05 eq. 5.6] 1 / (1 + (t^2)^b)     [AH05 eq. 5.7] exp(-t^2 / 2)
  return membership == Membership::bell ? 1.0 / (1.0 + std::exp(rule.slope * distance)) : std::exp(-0.5 * distance);
}

/// Derivatives of the logarithm of the degree of membership with respect to the premise parameters of its rule.
struct LogDerivatives {
  double width;
  double slope;
  double centre;
};

inline LogDerivatives log_derivatives(Membership membership, const Rule& rule, double u, double distance,
                                      double degree) {
  const double offset = u - rule.centre;
  if (membership == Membership::gaussian) {
    return {distance / rule.width, 0.0, offset / (rule.width * rule.width)};
  }
  const double rest = 1.0 - degree;
  if (offset == 0.0 || rest == 0.0) {
    return {0.0, 0.0, 0.0};
  }
  // ln mu = -ln(1 + t^(2b)), so that d ln mu / d ln t = -2b (1 - mu)
  return {2.0 * rule.slope * rest / rule.width, -rest * distance, 2.0 * rule.slope * rest / offset};
}

/// Turns degrees of membership into normalised firing strengths [AH05 eq. 5.9], in place. `distance` holds the distance
/// measures they came from: where all degrees underflow, their logarithms decide.
void normalise_strengths(Membership membership, std::span<const Rule> rules, std::span<const double> distance,
                         std::span<double> degree);

}  // namespace soak::anfis::inference
