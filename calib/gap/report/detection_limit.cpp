// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/detection_limit.h"

#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "calib/gap/report/slow_noise.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

/// Sets of sensors among which a term may be named: all, gyros, accelerometers, each alone.
constexpr double kSets = 9.0;

/// F of one and the given degrees of freedom whose upper tail is `p`.
double f_quantile(double p, double dof) {
  double low = 0.0;
  double high = 1.0;
  while (base::f_upper_tail(high, 1.0, dof) > p) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (base::f_upper_tail(middle, 1.0, dof) > p ? low : high) = middle;
  }
  return high;
}

}  // namespace

std::optional<double> detection_limit(const CampaignModel& model, std::size_t s, const SearchResult& found) {
  const Observations& observations = model.regressor_inputs().observations;
  if (!model.residuals().sensor[s] || found.candidates == 0) return std::nullopt;
  double visits = 0.0;
  double placements = 0.0;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const auto& row = observations.rows[i];
    if (i > 0 && row.placement == observations.rows[i - 1].placement) continue;
    placements += 1.0;
    if (i == 0 || row.visit != observations.rows[i - 1].visit || row.run != observations.rows[i - 1].run) visits += 1.0;
  }
  const NoiseComponents& noise = model.residuals().noise[s];
  const double blocks = static_cast<double>(observations.rows.size()) / placements;
  double of_visit = noise.visit * noise.visit +
                    (noise.placement * noise.placement + noise.block * noise.block / blocks) / (placements / visits);
  of_visit += wander_variance(observations, noise.wander);
  const double p = kGate / (static_cast<double>(found.candidates) * kSets);
  const double f = f_quantile(p, scatter_dof(noise) + observations.run_count() - 1);
  return std::sqrt(f * std::max(1.0, found.typical_heterogeneity) * of_visit / visits);
}

}  // namespace soak::calib::gap
