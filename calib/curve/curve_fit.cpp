// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/curve_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calib/curve/detail/curve_budget.h"
#include "calib/curve/detail/family_choice.h"
#include "calib/curve/families.h"
#include "calib/curve/one_way.h"

namespace soak::calib {
namespace {

constexpr std::size_t kRunsForHoldout = 3;
constexpr double kHysteresisP = 0.001;
/// A gap between heating and cooling is worth a warning from this many standard errors of one difference.
constexpr double kHysteresisRatio = 4.0;
constexpr double kDistinct_c = 0.5;
constexpr int kInNoFold = -1;
/// Error of a curve at its own rows over that at rows it had not seen: noise of a few rows reaches as far as this.
constexpr double kMostOverJudged = 1.25;

/// What the outer folds leave out, fold by fold.
struct OuterFolds {
  std::string kind = "none";
  std::vector<int> fold;  ///< of each row; kInNoFold: never left out
  std::vector<std::string> names;
};

base::Status check_curve_rows(const CurveData& data, const CurveSubject& subject) {
  if (data.rows.empty()) return base::bad_input("no rows to fit: no run gives a value of this sensor", subject.name);
  double low = data.rows.front().value;
  double high = low;
  for (const CurveRow& row : data.rows) {
    if (!std::isfinite(row.temp_c) || !std::isfinite(row.value)) {
      return base::bad_input("a row is not finite; void the segment it comes from", subject.name);
    }
    low = std::min(low, row.value);
    high = std::max(high, row.value);
  }
  if (low == high) {
    return base::bad_input(
        fmt::format("constant value {} at all temperatures: a stuck or disconnected sensor; void its runs or import "
                    "without the column",
                    low * subject.printed_per_unit),
        subject.name);
  }
  const std::size_t distinct = distinct_temperatures(data);
  if (distinct < kCurveTemperatures) {
    return base::bad_input(
        fmt::format("{} distinct temperatures; a thermal model needs at least {}", distinct, kCurveTemperatures),
        subject.name);
  }
  return {};
}

/// Runs that stayed at one plateau are in no fold: left out they would say nothing of the shape.
OuterFolds choose_folds(const CurveData& data, const std::set<int>& judges) {
  OuterFolds folds;
  std::set<int> branches;
  for (const CurveRow& row : data.rows) {
    if (judges.contains(row.run)) branches.insert(row.branch);
  }
  if (judges.size() >= kRunsForHoldout) {
    folds.kind = "run";
    folds.names = data.runs;
    for (const CurveRow& row : data.rows) folds.fold.push_back(judges.contains(row.run) ? row.run : kInNoFold);
  } else if (branches.size() >= 2) {
    folds.kind = "branch";
    folds.names = data.branches;
    for (const CurveRow& row : data.rows) folds.fold.push_back(judges.contains(row.run) ? row.branch : kInNoFold);
  } else if (data.rows.size() >= 20) {
    folds.kind = "block";
    folds.fold = block_folds(data);
    for (int i = 0; i <= *std::max_element(folds.fold.begin(), folds.fold.end()); ++i) {
      folds.names.push_back(fmt::format("block set {}", i + 1));
    }
  }
  return folds;
}

/// Squared errors of one family on one held-out fold.
struct FoldSums {
  double count = 0.0;
  double absolute = 0.0;  ///< Σ e²
  double shape = 0.0;     ///< Σ (e − mean e)²
};

/// Rows minus curve.
std::vector<double> curve_errors(const Curve& curve, const CurveData& data) {
  std::vector<double> temps_c;
  for (const CurveRow& row : data.rows) temps_c.push_back(row.temp_c);
  std::vector<double> errors(temps_c.size());
  evaluate(curve, temps_c, errors);
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = data.rows[i].value - errors[i];
  return errors;
}

FoldSums sums_of_errors(const Curve& curve, const CurveData& held_out) {
  FoldSums sums;
  double mean = 0.0;
  const std::vector<double> errors = curve_errors(curve, held_out);
  for (const double error : errors) mean += error;
  sums.count = static_cast<double>(errors.size());
  mean /= sums.count;
  for (const double error : errors) {
    sums.absolute += error * error;
    sums.shape += (error - mean) * (error - mean);
  }
  return sums;
}

using FamilySums = std::array<std::optional<FoldSums>, kFamilyCount>;

std::vector<FamilySums> run_outer_folds(const CurveData& data, const OuterFolds& folds, const CurveFitOptions& options,
                                        RuleChoice choice, const TrainedFamilies& whole, CurveFit& fit) {
  std::vector<FamilySums> all;
  for (std::size_t f = 0; f < folds.names.size(); ++f) {
    std::vector<bool> train(data.rows.size());
    std::vector<bool> test(data.rows.size());
    for (std::size_t i = 0; i < data.rows.size(); ++i) {
      test[i] = folds.fold[i] == static_cast<int>(f);
      train[i] = !test[i];
    }
    const CurveData held_out = select(data, test);
    if (held_out.rows.empty()) continue;
    const LeftOut left_out{whole, static_cast<int>(f)};
    const auto trained = train_families(select(data, train), options, choice, &left_out);
    if (!trained) continue;  // a fold that leaves too little to learn from says nothing about the model
    FoldErrors errors;
    errors.fold = folds.names[f];
    FamilySums sums;
    for (std::size_t k = 0; k < kFamilyCount; ++k) {
      if (!trained->fitted[k]) continue;
      sums[k] = sums_of_errors(trained->fitted[k]->curve, held_out);
      errors.rmse[k] = std::sqrt(sums[k]->absolute / sums[k]->count);
    }
    fit.checks.push_back(std::move(errors));
    all.push_back(sums);
  }
  return all;
}

void add_cross_validation(const std::vector<FamilySums>& folds, CurveFit& fit) {
  for (std::size_t k = 0; k < kFamilyCount; ++k) {
    FoldSums total;
    for (const FamilySums& fold : folds) {
      if (!fold[k]) continue;
      total.count += fold[k]->count;
      total.absolute += fold[k]->absolute;
      total.shape += fold[k]->shape;
    }
    if (total.count <= 0.0) continue;
    fit.cross_validation[k] =
        CrossValidationError{std::sqrt(total.absolute / total.count), std::sqrt(total.shape / total.count)};
  }
}

/// Whether family k's held-out shape error is below that of the ANFIS by more than one standard error of the
/// difference.
bool beats_anfis(const std::vector<FamilySums>& folds, std::size_t k) {
  constexpr auto anfis = static_cast<std::size_t>(Family::anfis);
  std::vector<double> differences;
  for (const FamilySums& fold : folds) {
    if (fold[k] && fold[anfis]) differences.push_back((fold[anfis]->shape - fold[k]->shape) / fold[k]->count);
  }
  const double n = static_cast<double>(differences.size());
  if (n < 2.0) return false;
  double mean = 0.0;
  for (const double d : differences) mean += d / n;
  double squares = 0.0;
  for (const double d : differences) squares += (d - mean) * (d - mean);
  return mean > std::sqrt(squares / (n - 1.0) / n);
}

/// Whether the ANFIS of all rows is the one that the folds have judged: fitted rows lie nearer to a curve than those of
/// runs that were left out, unless all rows together led to another number of rules than the rows of the folds.
bool anfis_is_as_judged(const CurveData& data, const Curve& curve, const CurveFit& fit) {
  const auto& judged = fit.cross_validation[static_cast<std::size_t>(Family::anfis)];
  if (!judged) return true;
  FoldSums sums;
  for (const int run : judging_runs(data)) {
    std::vector<bool> keep;
    for (const CurveRow& row : data.rows) keep.push_back(row.run == run);
    const FoldSums of_run = sums_of_errors(curve, select(data, keep));
    sums.count += of_run.count;
    sums.shape += of_run.shape;
  }
  return std::sqrt(sums.shape / sums.count) <= kMostOverJudged * judged->rmse_shape;
}

Family choose_winner(const std::vector<FamilySums>& folds, const CurveFit& fit, bool anfis_competes) {
  Family winner = Family::anfis;
  double least = 0.0;
  for (std::size_t k = 1; k < kFamilyCount; ++k) {
    if (!fit.cross_validation[k] || (anfis_competes && !beats_anfis(folds, k))) continue;
    if (winner == Family::anfis || fit.cross_validation[k]->rmse_shape < least) {
      winner = static_cast<Family>(k);
      least = fit.cross_validation[k]->rmse_shape;
    }
  }
  return winner;
}

void trace_curve(const CurveData& data, const TrainedFamilies& trained, std::span<const TypeBInput> type_b,
                 RuleChoice choice, CurveFit& fit) {
  const FittedCurve& fitted = *trained[fit.deployed];
  fit.curve = fitted.curve;
  const CurveVariance variance = variance_of(trained, fit.deployed, choice == RuleChoice::folds_over_runs);
  const std::vector<double> temps_c = temperatures_of(fit);
  const auto runs = static_cast<double>(fit.runs.size());
  fit.budget =
      curve_budget({data, fitted.curve, variance, trained.components, runs, fit.sweeps, type_b, fit.one_way}, temps_c);
  for (std::size_t i = 0; i < temps_c.size(); ++i) {
    CurvePoint point{temps_c[i], evaluate(fit.curve, temps_c[i]), expanded_uncertainty(fit.budget, Band::mean, i),
                     std::nullopt};
    if (fit.run_to_run_sigma) point.pi95 = expanded_uncertainty(fit.budget, Band::fresh_power_on, i);
    fit.points.push_back(point);
  }
}

/// Why a baseline was taken instead of the ANFIS.
std::string why_deployed(RuleChoice choice, bool anfis_competed) {
  if (choice == RuleChoice::expected_error) {
    return fmt::format(
        "is deployed: its misfit of the rows and the error that its parameters add are together less than those of "
        "the ANFIS; {}",
        kFewRunsAreNoJudge);
  }
  return anfis_competed ? "beats the ANFIS by more than one standard error on held-out runs and is deployed"
                        : "is deployed: the ANFIS fits all runs worse than those held out in turn";
}

void add_curve_warnings(const CurveSubject& subject, RuleChoice choice, bool anfis_competed, CurveFit& fit) {
  if (fit.runs.size() < kRunsForHoldout) {
    fit.warnings.push_back({"few_runs", fit.runs.size() == 1
                                            ? "one run only: no held-out error can be given, the run-to-run scatter is "
                                              "unknown and ci95 does not hold it; at "
                                              "least 3 runs are needed"
                                            : "two runs only: no held-out error can be given and the run-to-run "
                                              "scatter is hardly known; at least 3 runs are "
                                              "needed"});
  } else if (fit.holdout != "run") {
    fit.warnings.push_back({"few_runs", fmt::format("of {} power-ons fewer than 3 went over several temperatures: no "
                                                    "held-out error can be given; at least 3 such runs are needed",
                                                    fit.runs.size())});
  }
  if (fit.rules == 0) {
    fit.warnings.push_back({"few_temperatures", fmt::format("{}: too few temperatures for an ANFIS; {} is deployed",
                                                            subject.name, name_of(fit.deployed))});
  } else if (fit.deployed != Family::anfis) {
    fit.warnings.push_back({"baseline_deployed", fmt::format("{}: {} {}", subject.name, name_of(fit.deployed),
                                                             why_deployed(choice, anfis_competed))});
  }
  if (!fit.one_way.ranges.empty()) fit.warnings.push_back(one_way_warning(fit.one_way));
  const auto& gap = fit.sweeps;
  if (gap && gap->p_value < kHysteresisP && gap->largest > kHysteresisRatio * gap->noise) {
    fit.warnings.push_back(
        {"hysteresis",
         fmt::format("{}: heating and cooling differ by up to {:.3g} {} (near {:.0f} °C; noise {:.2g}), more than any "
                     "function of the thermometer can follow",
                     subject.name, gap->largest * subject.printed_per_unit, subject.printed_unit, gap->at_temp_c,
                     gap->noise * subject.printed_per_unit)});
  }
}

}  // namespace

std::vector<double> temperatures_of(const CurveFit& fit) {
  std::vector<double> temps_c;
  for (int i = 0; fit.temp_min_c + i <= fit.temp_max_c; ++i) temps_c.push_back(fit.temp_min_c + i);
  if (temps_c.back() < fit.temp_max_c) temps_c.push_back(fit.temp_max_c);
  return temps_c;
}

std::size_t distinct_temperatures(const CurveData& data) {
  std::vector<double> temps_c;
  for (const CurveRow& row : data.rows) temps_c.push_back(row.temp_c);
  return temperature_clusters(temps_c, kDistinct_c, temps_c.size()).size();
}

base::Result<CurveFit> fit_curve(const CurveData& data, const CurveFitOptions& options, const CurveSubject& subject,
                                 std::span<const TypeBInput> type_b, const KnownHysteresis& hysteresis) {
  if (const auto checked = check_curve_rows(data, subject); !checked) return base::forward_error(checked);
  const std::set<int> judges = judging_runs(data);
  const RuleChoice choice = rule_choice(judges.size());
  auto trained = train_families(data, options, choice);
  if (!trained) {
    base::Error error = trained.error();
    error.where = subject.name;
    return tl::unexpected<base::Error>(std::move(error));
  }
  CurveFit fit;
  fit.runs = data.runs;
  fit.rules = trained->rules;
  fit.membership = trained->membership;
  fit.training = trained->training;
  fit.lack_of_fit_sigma = trained->components.lack_of_fit_sigma;
  fit.run_to_run_sigma = trained->components.run_to_run_sigma;
  const auto [low, high] = std::minmax_element(data.rows.begin(), data.rows.end(),
                                               [](const auto& a, const auto& b) { return a.temp_c < b.temp_c; });
  fit.temp_min_c = low->temp_c;
  fit.temp_max_c = high->temp_c;

  const OuterFolds folds = choose_folds(data, judges);
  fit.holdout = folds.kind;
  const std::vector<FamilySums> sums = run_outer_folds(data, folds, options, choice, *trained, fit);
  fit.deployed = fit.rules > 0 ? Family::anfis : Family::spline;
  bool anfis_competed = true;
  if (folds.kind == "run") add_cross_validation(sums, fit);
  if (fit.rules > 0 && choice == RuleChoice::expected_error) {
    fit.deployed = least_expected_error(*trained);
  } else if (fit.rules > 0) {
    anfis_competed = anfis_is_as_judged(data, (*trained)[Family::anfis]->curve, fit);
    fit.deployed = choose_winner(sums, fit, anfis_competed);
  }
  const FoldSums train = sums_of_errors((*trained)[fit.rules > 0 ? Family::anfis : fit.deployed]->curve, data);
  fit.train_rmse = std::sqrt(train.absolute / train.count);
  fit.one_way.ranges = one_way_ranges(data);
  if (!fit.one_way.ranges.empty()) fit.one_way.known = hysteresis;
  fit.sweeps = find_sweep_gap(data, (*trained)[fit.deployed]->curve);
  trace_curve(data, *trained, type_b, choice, fit);
  for (const CurvePoint& point : fit.points) {
    if (std::isfinite(point.value) && std::isfinite(point.ci95)) continue;
    return base::bad_input("the curve is not finite: check the unit of the column and void the runs that are wrong",
                           subject.name);
  }
  add_curve_warnings(subject, choice, anfis_competed, fit);
  return fit;
}

}  // namespace soak::calib
