// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/uncertainty_budget.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace soak::calib {
namespace {

constexpr double kProbability = 0.95;

}  // namespace

double expanded_uncertainty(const std::vector<Contribution>& budget, Band band, std::size_t i) {
  double variance = 0.0;
  double denominator = 0.0;
  for (const Contribution& part : budget) {
    const std::vector<double>& u = band == Band::mean ? part.u : part.u_fresh;
    if (u.empty()) continue;
    const double squared = u[i] * u[i];
    variance += squared;
    if (part.degrees_of_freedom) denominator += squared * squared / std::max(1.0, *part.degrees_of_freedom);
  }
  if (variance <= 0.0) return 0.0;
  // ν_eff = u_c⁴ / Σ u_i⁴/ν_i, too many to matter where no part is estimated.
  constexpr double kMany = 1e6;
  const double degrees = denominator > 0.0 ? variance * variance / denominator : kMany;
  return base::student_t_two_sided(kProbability, std::clamp(degrees, 1.0, kMany)) * std::sqrt(variance);
}

}  // namespace soak::calib
