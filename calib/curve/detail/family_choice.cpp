// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/family_choice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anfis/select/structure_search.h"

namespace soak::calib {
namespace {

double expected_error(const FittedCurve& fitted) {
  return anfis::expected_squared_error(fitted.whitened_rss, fitted.parameters);
}

/// Weights of the families, 1 together; 0 of one that could not be fitted.
std::array<double, kFamilyCount> family_weights(const TrainedFamilies& trained) {
  const double least = expected_error(*trained[least_expected_error(trained)]);
  std::array<double, kFamilyCount> weights{};
  double sum = 0.0;
  for (std::size_t k = 0; k < kFamilyCount; ++k) {
    if (trained.fitted[k]) weights[k] = std::exp(-0.5 * (expected_error(*trained.fitted[k]) - least));
    sum += weights[k];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

CurveVariance variance_of_average(const TrainedFamilies& trained, Family deployed) {
  const std::array<double, kFamilyCount> weights = family_weights(trained);
  const auto sum = [&trained, weights](auto part) {
    double total = 0.0;
    for (std::size_t k = 0; k < kFamilyCount; ++k) {
      if (weights[k] > 0.0) total += weights[k] * part(*trained.fitted[k]);
    }
    return total;
  };
  return {[sum](double temp_c) { return sum([temp_c](const FittedCurve& f) { return f.variance(temp_c); }); },
          [sum, &curve = trained[deployed]->curve](double temp_c) {
            const double value = evaluate(curve, temp_c);
            return sum([=](const FittedCurve& f) { return std::pow(evaluate(f.curve, temp_c) - value, 2); });
          }};
}

}  // namespace

Family least_expected_error(const TrainedFamilies& trained) {
  Family best = Family::spline;
  for (std::size_t k = 0; k < kFamilyCount; ++k) {
    if (trained.fitted[k] && expected_error(*trained.fitted[k]) < expected_error(*trained[best])) {
      best = static_cast<Family>(k);
    }
  }
  return best;
}

CurveVariance variance_of(const TrainedFamilies& trained, Family deployed, bool by_held_out_runs) {
  if (!by_held_out_runs) return variance_of_average(trained, deployed);
  const auto& winner = trained[deployed];
  const auto& anfis = trained[Family::anfis];
  const auto nothing = [](double) { return 0.0; };
  if (deployed == Family::anfis || !anfis) return {winner->variance, nothing};
  return {[&winner, &anfis](double temp_c) {
            const double own = winner->variance(temp_c);
            return 0.5 * (own + std::max(own, anfis->variance(temp_c)));
          },
          nothing};
}

}  // namespace soak::calib
