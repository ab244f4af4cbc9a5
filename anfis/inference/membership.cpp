// SPDX-License-Identifier: Apache-2.0
#include "anfis/inference/membership.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace soak::anfis::inference {
namespace {

// Below this sum the degrees may be subnormal and their ratios rough.
constexpr double kSmallestSum = 1e-200;

double log_degree(Membership membership, const Rule& rule, double distance) {
  if (membership == Membership::gaussian) {
    return -0.5 * distance;
  }
  const double power = rule.slope * distance;
  return power > 0.0 ? -power - std::log1p(std::exp(-power)) : -std::log1p(std::exp(power));
}

}  // namespace

void normalise_strengths(Membership membership, std::span<const Rule> rules, std::span<const double> distance,
                         std::span<double> degree) {
  double sum = 0.0;
  for (const double d : degree) {
    sum += d;
  }
  if (sum < kSmallestSum) {
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < rules.size(); ++i) {
      largest = std::max(largest, log_degree(membership, rules[i], distance[i]));
    }
    sum = 0.0;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      degree[i] = std::exp(log_degree(membership, rules[i], distance[i]) - largest);
      sum += degree[i];
    }
  }
  for (double& d : degree) {
    d /= sum;
  }
}

}  // namespace soak::anfis::inference
