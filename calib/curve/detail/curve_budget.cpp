// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/detail/curve_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/statistics.h"

namespace soak::calib {
namespace {

// Heating against cooling.

constexpr double kSweepBin_c = 2.5;

/// Weighted mean of residuals.
struct WeightedMean {
  double weight = 0.0;
  double sum = 0.0;

  void add(double w, double value) {
    weight += w;
    sum += w * value;
  }
  [[nodiscard]] double value() const { return sum / weight; }
};

/// Residuals of one run in one bin of temperature.
struct SweepCell {
  WeightedMean up;
  WeightedMean down;
  WeightedMean temp_c;

  [[nodiscard]] bool both() const { return up.weight > 0.0 && down.weight > 0.0; }
  [[nodiscard]] double difference() const { return up.value() - down.value(); }
  [[nodiscard]] double variance() const { return 1.0 / up.weight + 1.0 / down.weight; }
};

/// Differences of one bin, run by run.
struct SweepBin {
  std::vector<double> differences;
  double own_variance = 0.0;  ///< mean of the runs' own variances
  double temp_c = 0.0;

  [[nodiscard]] double count() const { return static_cast<double>(differences.size()); }
  [[nodiscard]] double mean() const {
    double sum = 0.0;
    for (const double d : differences) sum += d / count();
    return sum;
  }
};

double typical_error(const CurveData& data) {
  std::vector<double> errors;
  for (const CurveRow& row : data.rows) {
    if (row.standard_error > 0.0) errors.push_back(row.standard_error);
  }
  return errors.empty() ? 0.0 : base::median(errors);
}

std::vector<SweepBin> collect_bins(const CurveData& data, const Curve& curve, double typical) {
  std::map<std::pair<long, int>, SweepCell> cells;
  for (const CurveRow& row : data.rows) {
    if (row.sweep == Sweep::unknown) continue;
    const double se = std::max(row.standard_error, typical);
    SweepCell& cell = cells[{std::lround(row.temp_c / kSweepBin_c), row.run}];
    (row.sweep == Sweep::up ? cell.up : cell.down).add(1.0 / (se * se), row.value - evaluate(curve, row.temp_c));
    cell.temp_c.add(1.0, row.temp_c);
  }
  std::map<long, SweepBin> bins;
  for (const auto& [key, cell] : cells) {
    if (!cell.both()) continue;
    SweepBin& bin = bins[key.first];
    bin.differences.push_back(cell.difference());
    bin.own_variance += cell.variance();
    bin.temp_c += cell.temp_c.value();
  }
  std::vector<SweepBin> list;
  for (auto& [key, bin] : bins) {
    bin.own_variance /= bin.count();
    bin.temp_c /= bin.count();
    list.push_back(std::move(bin));
  }
  return list;
}

/// Variance of one run's difference: pooled scatter between runs, at least what the rows say themselves.
double variance_of_one(const std::vector<SweepBin>& bins) {
  double squares = 0.0;
  double degrees = 0.0;
  double own = 0.0;
  for (const SweepBin& bin : bins) {
    own += bin.own_variance / static_cast<double>(bins.size());
    for (const double d : bin.differences) squares += (d - bin.mean()) * (d - bin.mean());
    degrees += bin.count() - 1.0;
  }
  return degrees > 0.0 ? std::max(own, squares / degrees) : own;
}

// Contributions.

/// Where the variance of a curve comes from at one temperature.
struct VarianceShares {
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

/// Variance of one run's offset for the budget. Of up to three runs that of the estimated offsets as it is, which the t
/// factor of R − 1 belongs to: less what noise contributes it would often be zero.
double run_variance(const CurveEvidence& evidence) {
  const VarianceComponents& components = evidence.components;
  const double own = std::pow(components.run_to_run_sigma.value_or(0.0), 2);
  const bool few = evidence.runs <= static_cast<double>(kRunsWithoutFolds);
  return few ? components.estimated_offset_variance.value_or(own) : own;
}

VarianceShares shares_at(const CurveEvidence& evidence, double noise_share, double temp_c) {
  const VarianceComponents& components = evidence.components;
  const double all = evidence.variance.own(temp_c);
  VarianceShares shares;
  shares.level = std::min(all, run_variance(evidence) / evidence.runs);
  const double branches = static_cast<double>(count_offsets(evidence.data));
  const double of_branches = std::min(all, std::pow(components.branch_sigma.value_or(0.0), 2) / branches);
  const double within = all - shares.level - of_branches;
  shares.noise = noise_share * within;
  shares.model = (1.0 - noise_share) * within + of_branches + evidence.variance.between_families(temp_c);
  return shares;
}

/// Fills u and u_fresh from variances at each temperature.
template <class Mean, class Fresh>
void fill_contribution(Contribution& part, std::span<const VarianceShares> at, bool with_fresh, Mean mean,
                       Fresh fresh) {
  for (const VarianceShares& shares : at) {
    part.u.push_back(std::sqrt(std::max(0.0, mean(shares))));
    if (with_fresh) part.u_fresh.push_back(std::sqrt(std::max(0.0, fresh(shares))));
  }
}

bool holds(const std::vector<OneWayRange>& ranges, double temp_c) {
  return std::ranges::any_of(ranges,
                             [&](const OneWayRange& range) { return temp_c >= range.low_c && temp_c <= range.high_c; });
}

std::string hysteresis_basis(const CurveEvidence& evidence) {
  const std::string measured =
      evidence.gap ? "half the gap between heating and cooling, less noise; the curve is their mean" : "";
  if (evidence.one_way.ranges.empty() || evidence.one_way.known.source == HysteresisSource::none) {
    if (!evidence.gap) return "not stated: no temperature was visited both heating and cooling in the same run";
    return measured + (evidence.one_way.ranges.empty() ? "" : ", but not everywhere: elsewhere nothing is stated");
  }
  return fmt::format("{}{}half the gap that the {} where only one way was recorded; the curve is that branch", measured,
                     measured.empty() ? "" : "; ",
                     evidence.one_way.known.source == HysteresisSource::type ? "unit's type states"
                                                                             : "newest models of the type show");
}

/// `variance`: of half the gap that the runs themselves show.
Contribution hysteresis_part(const CurveEvidence& evidence, std::span<const double> temps_c, double variance) {
  Contribution part{.name = "hysteresis", .basis = hysteresis_basis(evidence)};
  if (evidence.gap) part.degrees_of_freedom = evidence.components.degrees_of_freedom;
  const bool known = !evidence.one_way.ranges.empty() && evidence.one_way.known.source != HysteresisSource::none;
  if (known) part.type = 'B';
  if (!known && !evidence.gap) return part;
  for (const double temp_c : temps_c) {
    const double half = known && holds(evidence.one_way.ranges, temp_c) ? evidence.one_way.known.half_gap : 0.0;
    if (known) part.u.push_back(half);
    // the curve's own branch is half a gap from the mean, that of the next power-on as far on either side
    if (evidence.components.run_to_run_sigma) {
      part.u_fresh.push_back(std::hypot(half, std::max(half, std::sqrt(variance))));
    }
  }
  return part;
}

/// |db/dT| over one kelvin, inside the range of the points.
double slope_at(const Curve& curve, double temp_c, std::span<const double> temps_c) {
  const double below = std::max(temp_c - 0.5, temps_c.front());
  const double above = std::min(temp_c + 0.5, temps_c.back());
  return above > below ? std::abs(evaluate(curve, above) - evaluate(curve, below)) / (above - below) : 0.0;
}

Contribution type_b_part(const TypeBInput& input, const CurveEvidence& evidence, std::span<const double> temps_c) {
  Contribution part{.name = input.name, .type = 'B', .basis = input.basis};
  if (!input.stated) return part;
  for (const double temp_c : temps_c) {
    part.u.push_back(std::hypot(input.constant, input.temperature_c * slope_at(evidence.curve, temp_c, temps_c)));
  }
  if (evidence.components.run_to_run_sigma) part.u_fresh = part.u;
  return part;
}

}  // namespace

std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve) {
  const double typical = typical_error(data);
  if (typical <= 0.0) return std::nullopt;
  const std::vector<SweepBin> bins = collect_bins(data, curve, typical);
  if (bins.empty()) return std::nullopt;
  const double variance = variance_of_one(bins);
  SweepGap gap;
  double chi_squared = 0.0;
  double mean_square = 0.0;
  for (const SweepBin& bin : bins) {
    chi_squared += bin.mean() * bin.mean() * bin.count() / variance;
    mean_square += (bin.mean() * bin.mean() - variance / bin.count()) / static_cast<double>(bins.size());
    if (std::abs(bin.mean()) <= gap.largest) continue;
    gap.largest = std::abs(bin.mean());
    gap.at_temp_c = bin.temp_c;
    gap.noise = std::sqrt(variance / bin.count());
  }
  gap.half_sigma = 0.5 * std::sqrt(std::max(0.0, mean_square));
  gap.p_value = base::chi_squared_upper_tail(chi_squared, static_cast<double>(bins.size()));
  return gap;
}

std::vector<Contribution> curve_budget(const CurveEvidence& evidence, std::span<const double> temps_c) {
  const VarianceComponents& components = evidence.components;
  const bool fresh = components.run_to_run_sigma.has_value();
  const double between = run_variance(evidence);
  const double lack = std::pow(components.lack_of_fit_sigma, 2);
  const double loop = evidence.gap ? std::min(lack, std::pow(evidence.gap->half_sigma, 2)) : 0.0;
  const double share = noise_share(evidence);
  std::vector<VarianceShares> at;
  for (const double temp_c : temps_c) at.push_back(shares_at(evidence, share, temp_c));

  const double within = components.degrees_of_freedom;
  Contribution noise{.name = "noise", .basis = "standard errors of the segments' means"};
  if (!rows_state_errors(evidence.data)) noise.degrees_of_freedom = within;
  const auto of_noise = [](const VarianceShares& s) { return s.noise; };
  fill_contribution(noise, at, fresh, of_noise, of_noise);

  Contribution runs{.name = "run_to_run", .degrees_of_freedom = evidence.runs - 1.0};
  runs.basis = "not stated: one run alone hides its own offset";
  if (fresh) {
    runs.basis = fmt::format("scatter of the offsets of {} runs", evidence.runs);
    fill_contribution(
        runs, at, fresh, [](const VarianceShares& s) { return s.level; },
        [between](const VarianceShares& s) { return s.level + between; });
  }

  Contribution model{.name = "model", .degrees_of_freedom = within};
  model.basis = "scatter within runs that neither noise nor hysteresis explains, and families that differ";
  fill_contribution(
      model, at, fresh, [](const VarianceShares& s) { return s.model; },
      [lack, loop](const VarianceShares& s) { return s.model + lack - loop; });

  std::vector<Contribution> budget = {noise, runs, hysteresis_part(evidence, temps_c, loop)};
  for (const TypeBInput& input : evidence.type_b) budget.push_back(type_b_part(input, evidence, temps_c));
  budget.push_back(model);
  return budget;
}

}  // namespace soak::calib
