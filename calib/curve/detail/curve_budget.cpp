// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/curve_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace soak::calib {
namespace {

/// Where the variance of a curve comes from at one temperature.
struct Shares {
  double level = 0.0;  ///< the runs' mean offset
  double noise = 0.0;
  double model = 0.0;
};

/// The part of a curve's variance within runs that the rows' own standard errors make, the rest being lack of fit: as
/// if all rows had the same leverage.
double noise_share(const CurveEvidence& evidence) {
  const double lack = std::pow(evidence.components.lack_of_fit_sigma, 2);
  double noise = 0.0;
  double both = 0.0;
  for (const CurveRow& row : evidence.data.rows) {
    const double own = row.standard_error * row.standard_error;
    if (own + lack <= 0.0) continue;
    const double weight = 1.0 / (own + lack);
    noise += weight * weight * own;
    both += weight;
  }
  return both > 0.0 ? noise / both : 1.0;
}

/// Whether every row has a standard error of its own: each comes from hundreds of samples, all together from so many
/// that their degrees of freedom do not matter.
bool rows_state_errors(const CurveData& data) {
  return std::all_of(data.rows.begin(), data.rows.end(), [](const CurveRow& row) { return row.standard_error > 0.0; });
}

Shares shares_at(const CurveEvidence& evidence, double noise_share, double temp_c) {
  const double all = evidence.variance(temp_c);
  const double between = std::pow(evidence.components.run_to_run_sigma.value_or(0.0), 2);
  Shares shares;
  shares.level = std::min(all, between / evidence.runs);
  shares.noise = noise_share * (all - shares.level);
  shares.model = (1.0 - noise_share) * (all - shares.level);
  return shares;
}

/// Fills u and u_fresh from variances at each temperature.
template <class Mean, class Fresh>
void fill(Contribution& part, std::span<const Shares> at, bool with_fresh, Mean mean, Fresh fresh) {
  for (const Shares& shares : at) {
    part.u.push_back(std::sqrt(std::max(0.0, mean(shares))));
    if (with_fresh) part.u_fresh.push_back(std::sqrt(std::max(0.0, fresh(shares))));
  }
}

Contribution hysteresis(const CurveEvidence& evidence, std::size_t points, double variance) {
  Contribution part{.name = "hysteresis", .degrees_of_freedom = evidence.components.degrees_of_freedom};
  if (!evidence.gap) {
    part.basis = "not stated: no temperature was visited both heating and cooling in the same run";
    return part;
  }
  part.basis = "half the gap between heating and cooling, less noise; the curve is their mean";
  if (evidence.components.run_to_run_sigma) part.u_fresh.assign(points, std::sqrt(variance));
  return part;
}

/// |db/dT| over one kelvin, inside the range of the points.
double slope_at(const Curve& curve, double temp_c, std::span<const double> temps_c) {
  const double below = std::max(temp_c - 0.5, temps_c.front());
  const double above = std::min(temp_c + 0.5, temps_c.back());
  return above > below ? std::abs(evaluate(curve, above) - evaluate(curve, below)) / (above - below) : 0.0;
}

Contribution type_b(const TypeBInput& input, const CurveEvidence& evidence, std::span<const double> temps_c) {
  Contribution part{.name = input.name, .type = 'B', .basis = input.basis};
  if (!input.stated) return part;
  for (const double temp_c : temps_c) {
    part.u.push_back(std::hypot(input.constant, input.temperature_c * slope_at(evidence.curve, temp_c, temps_c)));
  }
  if (evidence.components.run_to_run_sigma) part.u_fresh = part.u;
  return part;
}

}  // namespace

std::vector<Contribution> curve_budget(const CurveEvidence& evidence, std::span<const double> temps_c) {
  const VarianceComponents& components = evidence.components;
  const bool fresh = components.run_to_run_sigma.has_value();
  const double between = std::pow(components.run_to_run_sigma.value_or(0.0), 2);
  const double lack = std::pow(components.lack_of_fit_sigma, 2);
  const double loop = evidence.gap ? std::min(lack, std::pow(evidence.gap->half_sigma, 2)) : 0.0;
  const double share = noise_share(evidence);
  std::vector<Shares> at;
  for (const double temp_c : temps_c) at.push_back(shares_at(evidence, share, temp_c));

  const double within = components.degrees_of_freedom;
  Contribution noise{.name = "noise", .basis = "standard errors of the segments' means"};
  if (!rows_state_errors(evidence.data)) noise.degrees_of_freedom = within;
  const auto of_noise = [](const Shares& s) { return s.noise; };
  fill(noise, at, fresh, of_noise, of_noise);

  Contribution runs{.name = "run_to_run", .degrees_of_freedom = evidence.runs - 1.0};
  runs.basis = "not stated: one run alone hides its own offset";
  if (fresh) {
    runs.basis = fmt::format("scatter of the offsets of {} runs", evidence.runs);
    fill(
        runs, at, fresh, [](const Shares& s) { return s.level; },
        [between](const Shares& s) { return s.level + between; });
  }

  Contribution model{.name = "model", .degrees_of_freedom = within};
  model.basis = "scatter within runs that neither noise nor hysteresis explains";
  fill(
      model, at, fresh, [](const Shares& s) { return s.model; },
      [lack, loop](const Shares& s) { return s.model + lack - loop; });

  std::vector<Contribution> budget = {noise, runs, hysteresis(evidence, temps_c.size(), loop)};
  for (const TypeBInput& input : evidence.type_b) budget.push_back(type_b(input, evidence, temps_c));
  budget.push_back(model);
  return budget;
}

}  // namespace soak::calib
