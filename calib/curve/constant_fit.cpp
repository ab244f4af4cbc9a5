// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/constant_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "calib/curve/families.h"

namespace soak::calib {
namespace {

constexpr double kNear_c = 10.0;
constexpr std::size_t kRunsToTell = 3;

double span_c(const CurveData& data) {
  const auto [low, high] = std::ranges::minmax_element(data.rows, {}, &CurveRow::temp_c);
  return high->temp_c - low->temp_c;
}

/// A run's weighted mean, with the effective degrees of freedom of its variance; 0 = many.
struct RunMean {
  double value = 0.0;
  double variance = 0.0;
  double freedoms = 0.0;
};

/// Rows without standard errors weigh the same; their scatter is the measure then.
RunMean mean_of_rows(const std::vector<CurveRow>& rows) {
  const bool stated = std::ranges::all_of(rows, [](const CurveRow& row) { return row.standard_error > 0.0; });
  RunMean mean;
  double weights = 0.0;
  for (const CurveRow& row : rows) {
    const double weight = stated ? std::pow(row.standard_error, -2) : 1.0;
    weights += weight;
    mean.value += weight * row.value;
  }
  mean.value /= weights;
  double chi_squared = 0.0;
  double fourth = 0.0;
  for (const CurveRow& row : rows) {
    const double weight = stated ? std::pow(row.standard_error, -2) : 1.0;
    chi_squared += weight * std::pow(row.value - mean.value, 2);
    if (row.freedoms > 0.0) fourth += std::pow(weight / weights, 4) / (row.freedoms * weight * weight);
  }
  const double spare = static_cast<double>(rows.size()) - 1.0;
  const double scatter = spare > 0.0 ? chi_squared / spare : 0.0;
  mean.variance = (stated ? std::max(1.0, scatter) : scatter) / weights;
  if (stated && scatter <= 1.0) {
    mean.freedoms = fourth > 0.0 ? std::pow(weights, -2) / fourth : 0.0;
  } else {
    mean.freedoms = spare;
  }
  return mean;
}

std::vector<RunMean> means_of_runs(const CurveData& data) {
  std::vector<RunMean> means;
  for (std::size_t run = 0; run < data.runs.size(); ++run) {
    std::vector<CurveRow> rows;
    for (const CurveRow& row : data.rows) {
      if (row.run == static_cast<int>(run)) rows.push_back(row);
    }
    if (!rows.empty()) means.push_back(mean_of_rows(rows));
  }
  return means;
}

/// The mean over runs, and what its variance is made of.
struct OverRuns {
  double value = 0.0;
  double noise_variance = 0.0;
  double noise_freedoms = 0.0;          ///< 0 = many
  double estimated_run_variance = 0.0;  ///< of the runs' means
  double run_variance = 0.0;            ///< of one run's offset: that, less what noise contributes
  double count = 0.0;
};

OverRuns average(const std::vector<RunMean>& means) {
  OverRuns over;
  over.count = static_cast<double>(means.size());
  double fourth = 0.0;
  for (const RunMean& mean : means) {
    over.value += mean.value / over.count;
    over.noise_variance += mean.variance / (over.count * over.count);
    if (mean.freedoms > 0.0) fourth += std::pow(mean.variance / (over.count * over.count), 2) / mean.freedoms;
  }
  if (fourth > 0.0) over.noise_freedoms = over.noise_variance * over.noise_variance / fourth;
  if (means.size() < 2) return over;
  double squares = 0.0;
  for (const RunMean& mean : means) squares += std::pow(mean.value - over.value, 2);
  over.estimated_run_variance = squares / (over.count - 1.0);
  over.run_variance = std::max(0.0, over.estimated_run_variance - over.count * over.noise_variance);
  return over;
}

/// Variances of the mean over runs: of up to three runs the scatter of their means as it is, which holds their noise
/// (detail/curve_budget.h).
struct MeanShares {
  double one_run = 0.0;  ///< of one run's offset
  double noise = 0.0;
};

MeanShares shares_of(const OverRuns& over) {
  const bool few = over.count >= 2.0 && over.count <= static_cast<double>(kRunsWithoutFolds);
  if (!few) return {over.run_variance, over.noise_variance};
  const double scatter = over.estimated_run_variance;
  return {scatter, std::max(0.0, over.noise_variance - scatter / over.count)};
}

Contribution constant_part(std::string name, double u, std::size_t points, bool fresh, std::string basis) {
  Contribution part{.name = std::move(name), .basis = std::move(basis)};
  part.u.assign(points, u);
  if (fresh) part.u_fresh = part.u;
  return part;
}

Contribution temperature_part(const std::vector<double>& temps_c, const ConstantValidity& validity,
                              const std::optional<double>& change_per_k, const CurveSubject& subject, bool fresh) {
  Contribution part{.name = "temperature", .type = 'B'};
  if (!change_per_k) {
    part.basis = fmt::format("not stated: the unit's type does not say how much {} changes per kelvin", subject.name);
    return part;
  }
  part.basis = fmt::format("at most {:.3g} {} per kelvin (unit's type) away from where it was measured",
                           *change_per_k * subject.printed_per_unit, subject.printed_unit);
  const double middle_c = 0.5 * (validity.temp_min_c + validity.temp_max_c);
  for (const double temp_c : temps_c)
    part.u.push_back(*change_per_k * std::abs(temp_c - middle_c) / std::numbers::sqrt3);
  if (fresh) part.u_fresh = part.u;
  return part;
}

std::vector<Contribution> constant_budget(const OverRuns& over, const std::vector<double>& temps_c,
                                          const ConstantValidity& validity, const std::optional<double>& change_per_k,
                                          const CurveSubject& subject, std::span<const TypeBInput> type_b) {
  const bool fresh = over.count > 1.0;
  const std::size_t points = temps_c.size();
  const MeanShares shares = shares_of(over);
  std::vector<Contribution> budget;
  budget.push_back(
      constant_part("noise", std::sqrt(shares.noise), points, fresh, "standard errors of the sessions' estimates"));
  if (over.noise_freedoms > 0.0) budget.back().degrees_of_freedom = over.noise_freedoms;
  Contribution runs{.name = "run_to_run", .degrees_of_freedom = over.count - 1.0};
  runs.basis = "not stated: one run alone hides its own offset";
  if (fresh) {
    runs.basis = fmt::format("scatter of the offsets of {} runs", over.count);
    runs.u.assign(points, std::sqrt(shares.one_run / over.count));
    runs.u_fresh.assign(points, std::sqrt(shares.one_run * (1.0 + 1.0 / over.count)));
  }
  budget.push_back(std::move(runs));
  budget.push_back(temperature_part(temps_c, validity, change_per_k, subject, fresh));
  for (const TypeBInput& input : type_b) {
    if (input.name == "thermometer") continue;  // a constant has no slope for its error to act on
    Contribution part{.name = input.name, .type = 'B', .basis = input.basis};
    if (input.stated) part.u.assign(points, input.constant);
    if (input.stated && fresh) part.u_fresh = part.u;
    budget.push_back(std::move(part));
  }
  return budget;
}

/// The same value at both ends of the valid range.
Curve constant_curve(double value, double low_c, double high_c) {
  if (high_c > low_c) return TableCurve{low_c, high_c - low_c, {value, value}};
  return TableCurve{low_c, 1.0, {value}};
}

void add_constant_warnings(const ConstantValidity& validity, CurveFit& fit) {
  if (fit.runs.size() < kRunsToTell) {
    fit.warnings.push_back(
        {"few_runs",
         fit.runs.size() == 1
             ? "one run only: the scatter from power-on to power-on is unknown and ci95 does not include it; at "
               "least 3 runs are needed"
             : "two runs only: the scatter from power-on to power-on is hardly known; at least 3 runs are "
               "needed"});
  }
  fit.warnings.push_back(
      {"one_temperature",
       fmt::format("measured at {:.1f} to {:.1f} °C only: constants, valid from {:.1f} to {:.1f} °C{}",
                   validity.temp_min_c, validity.temp_max_c, fit.temp_min_c, fit.temp_max_c,
                   validity.within_c > 0.0 ? " (as the unit's type says)"
                                           : " (the unit's type does not say how far beyond: [constants] within_c)")});
}

}  // namespace

bool is_of_one_temperature(const CurveData& data) {
  if (data.rows.empty() || span_c(data) > kNear_c) return false;
  if (distinct_temperatures(data) < kCurveTemperatures) return true;
  for (std::size_t run = 0; run < data.runs.size(); ++run) {
    CurveData own;
    for (const CurveRow& row : data.rows) {
      if (row.run == static_cast<int>(run)) own.rows.push_back(row);
    }
    if (distinct_temperatures(own) > 1) return false;
  }
  return true;
}

base::Result<CurveFit> fit_constant(const CurveData& data, const CurveSubject& subject,
                                    const ConstantValidity& validity, const std::optional<double>& change_per_k,
                                    std::span<const TypeBInput> type_b) {
  const auto finite = [](const CurveRow& row) { return std::isfinite(row.temp_c) && std::isfinite(row.value); };
  if (data.rows.empty() || !std::ranges::all_of(data.rows, finite)) {
    return base::bad_input("a row is not finite, or there is none; void the segment it comes from", subject.name);
  }
  const OverRuns over = average(means_of_runs(data));
  CurveFit fit;
  fit.deployed = Family::constant;
  fit.runs = data.runs;
  fit.holdout = "none";
  fit.temp_min_c = validity.temp_min_c - validity.within_c;
  fit.temp_max_c = validity.temp_max_c + validity.within_c;
  if (over.count > 1.0) fit.run_to_run_sigma = std::sqrt(over.run_variance);
  double squares = 0.0;
  for (const CurveRow& row : data.rows) squares += std::pow(row.value - over.value, 2);
  fit.train_rmse = std::sqrt(squares / static_cast<double>(data.rows.size()));
  fit.curve = constant_curve(over.value, fit.temp_min_c, fit.temp_max_c);
  const std::vector<double> temps_c = temperatures_of(fit);
  fit.budget = constant_budget(over, temps_c, validity, change_per_k, subject, type_b);
  for (std::size_t i = 0; i < temps_c.size(); ++i) {
    CurvePoint point{temps_c[i], over.value, expanded_uncertainty(fit.budget, Band::mean, i), std::nullopt};
    if (fit.run_to_run_sigma) point.pi95 = expanded_uncertainty(fit.budget, Band::fresh_power_on, i);
    fit.points.push_back(point);
  }
  add_constant_warnings(validity, fit);
  return fit;
}

}  // namespace soak::calib
