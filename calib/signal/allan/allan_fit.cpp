// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "base/statistics.h"
#include "calib/signal/allan/detail/coefficients.h"
#include "calib/signal/allan/detail/low_pass_curve.h"
#include "calib/signal/allan/detail/markov_search.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr std::size_t kFewestPoints = 5;
constexpr std::size_t kMostPoints = 32;
/// Averaging times of the fit lie at least so far apart: denser ones add nothing but rounding errors.
constexpr double kLeastRatio = 1.25;
/// A curve whose variance falls slower than tau^-0.2 at its end counts as flat there.
constexpr double kFlatSlope = -0.2;
/// Averaging times from so many periods of a low-pass' corner on: what the filter still remembers there is less than
/// 1e-3 of the variance for all but the slowest to settle (Butterworth of fourth order: 3e-3).
constexpr double kBeyondLowPass = 3.0;
/// The lag of a low-pass is known to this share (one standard deviation): the form is not exactly the filter's.
constexpr double kLagError = 0.1;
/// And to so many sample intervals, where a filter is too fast for the spectrum to show it.
constexpr double kLeastLagError = 0.015;

base::Status check_curve(const AllanCurve& curve) {
  if (!(curve.interval_s > 0.0) || !std::isfinite(curve.interval_s)) {
    return base::bad_input("the sample interval must be positive", "interval_s");
  }
  if (curve.multiples.size() != curve.deviation.size()) {
    return base::bad_input("as many deviations as averaging times are needed", "deviation");
  }
  if (curve.multiples.size() < kFewestPoints) {
    return base::bad_input("a fit needs at least 5 averaging times, there are " +
                               std::to_string(curve.multiples.size()) + ": the record is too short",
                           "multiples");
  }
  if (curve.stretches.empty()) return base::bad_input("the lengths of the stretches are missing", "stretches");
  const std::size_t longest = *std::max_element(curve.stretches.begin(), curve.stretches.end());
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    const std::string where = "averaging time " + std::to_string(i);
    if (curve.multiples[i] == 0 || (i > 0 && curve.multiples[i] <= curve.multiples[i - 1])) {
      return base::bad_input("averaging times must be positive and rise", where);
    }
    if (curve.multiples[i] > (longest - std::min<std::size_t>(longest, 1)) / 2) {
      return base::bad_input("no stretch has a difference at this averaging time", where);
    }
    if (!(curve.deviation[i] > 0.0) || !std::isnormal(curve.deviation[i])) {
      return base::bad_input("deviations must be positive numbers of full precision", where);
    }
  }
  return {};
}

/// Geometric mean of the deviations: the fit works on numbers about 1, whose squares and fourth powers exist.
double size_of(const std::vector<double>& deviations) {
  double sum = 0.0;
  for (const double deviation : deviations) sum += std::log(deviation);
  return std::exp(sum / static_cast<double>(deviations.size()));
}

/// Every averaging time that lies far enough beyond the one before.
Points thinned(const AllanCurve& curve, double lag) {
  const double first = static_cast<double>(curve.multiples.front());
  const double range = static_cast<double>(curve.multiples.back()) / first;
  const double ratio = std::max(kLeastRatio, std::pow(range, 1.0 / static_cast<double>(kMostPoints - 1)));
  Points points;
  points.lag = lag;
  // Slower sampling than any filter's corner: no memory from sample to sample.
  const bool may_be_filtered = 1.0 / curve.interval_s >= 4.0 * kLeastCorner_hz;
  if (may_be_filtered) points.lag_error = std::hypot(kLagError * lag, kLeastLagError);
  points.shortest_markov_time = std::max(1.0, 1.0 / (2.0 * std::numbers::pi * kLeastCorner_hz * curve.interval_s));
  std::vector<double> variance;
  double next = 0.0;
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    const auto m = static_cast<double>(curve.multiples[i]);
    if (m < next * (1.0 - 1e-9)) continue;
    points.multiples.push_back(m);
    variance.push_back(curve.deviation[i] * curve.deviation[i]);
    next = m * ratio;
  }
  points.variance = Eigen::Map<const Eigen::VectorXd>(variance.data(), static_cast<Eigen::Index>(variance.size()));
  return points;
}

/// d ln(variance)/d ln(tau) at the end of the fitted curve.
double end_slope(const std::vector<std::size_t>& multiples, const Eigen::VectorXd& fitted) {
  const Eigen::Index n = fitted.size();
  const auto m = [&](std::size_t back) { return static_cast<double>(multiples[multiples.size() - back]); };
  return std::log(fitted[n - 1] / fitted[n - 2]) / std::log(m(1) / m(2));
}

void add_curve(const AllanCurve& curve, const Fitted& fit, AllanFit& result) {
  const std::vector<double> multiples(curve.multiples.begin(), curve.multiples.end());
  const Eigen::MatrixXd curves = term_curves(multiples, fit.table.markov_time(), fit.lag);
  const Model& best = fit.solution.best();
  const Eigen::VectorXd fitted = curves(Eigen::all, best.columns) * best.estimate;
  result.deviation.assign(fitted.begin(), fitted.end());
  for (double& value : result.deviation) value = std::sqrt(value);
  Eigen::Index at = 0;
  fitted.minCoeff(&at);
  result.bias_instability = flicker_of_least(fit, multiples, fitted[at]);
  result.bias_instability_tau_s = multiples[static_cast<std::size_t>(at)] * curve.interval_s;
  if (end_slope(curve.multiples, fitted) < kFlatSlope) {
    result.bias_instability.found = false;
    result.bias_instability.low = 0.0;
  }
}

/// 2/edf of the measured variance at averaging time m. A pure ramp has no variance at all: the error of the model
/// bounds the degrees of freedom. Where the model misfits, its noise is not the curve's: then the widest of the power
/// laws, and no less than the misfit itself.
double scatter(const TermPairs& pairs, const PerTerm& theta, double m, double measured, double fitted, bool misfit) {
  const double model = relative_variance(pairs, theta, fitted) + kModelError * kModelError;
  if (!misfit) return model;
  const double residual = (measured - fitted) / measured;
  return std::max({model, power_law_relative_variance(pairs, m), residual * residual});
}

/// Two-sided 95 % of a deviation whose square is chi-squared.
std::array<double, 2> interval(double deviation, double edf) {
  const auto bound = [&](double p) { return deviation * std::sqrt(edf / base::chi_squared_quantile(p, edf)); };
  return {bound(kTails[1]), bound(kTails[0])};
}

void add_intervals(const AllanCurve& curve, const PairCounts& counts, const Fitted& fit, AllanFit& result) {
  const PerTerm theta = fit.solution.best().theta();
  const bool misfit = misfits(fit.solution);
  for (std::size_t i = 0; i < curve.multiples.size(); ++i) {
    const auto m = static_cast<double>(curve.multiples[i]);
    const double measured = curve.deviation[i] * curve.deviation[i];
    const double fitted = result.deviation[i] * result.deviation[i];
    const TermPairs pairs = covariance_terms(counts, m, m, fit.table.markov_time());
    // No quadratic form of Gaussian noise has less than one degree of freedom.
    const double edf = 2.0 / std::min(2.0, scatter(pairs, theta, m, measured, fitted, misfit));
    result.degrees_of_freedom.push_back(edf);
    result.ci95.push_back(interval(curve.deviation[i], edf));
  }
}

/// theta counts time in intervals: Q = sqrt(theta) tau0, N = sqrt(theta tau0), K = sqrt(theta/tau0), R =
/// sqrt(theta)/tau0
void add_coefficients(const AllanCurve& curve, const Fitted& fit, AllanFit& result) {
  const std::vector<double> multiples(curve.multiples.begin(), curve.multiples.end());
  std::vector<double> highest;
  for (const auto& [low, high] : result.ci95) highest.push_back(high * high);
  const UpperCurve upper{multiples, highest, fit.lag};
  const double tau0 = curve.interval_s;
  result.quantization = term_coefficient(fit, upper, quantization, tau0);
  result.angle_random_walk = term_coefficient(fit, upper, white, std::sqrt(tau0));
  result.flicker = term_coefficient(fit, upper, flicker, 1.0);
  result.rate_random_walk = term_coefficient(fit, upper, random_walk, 1.0 / std::sqrt(tau0));
  result.rate_ramp = term_coefficient(fit, upper, ramp, 1.0 / tau0);
  result.markov_sigma = markov_sigma(fit, upper, 1.0);
  result.markov_time_s = markov_time(fit, tau0);
  // Where the curve still falls, flicker may hide below it.
  AllanCoefficient& least = result.bias_instability;
  if (!least.found) least.high = std::max(least.high, result.flicker.high);
  limit(least, std::sqrt(largest_theta(upper, flicker, 0.0)), misfits(fit.solution));
}

constexpr std::array kDeviationTerms = {
    &AllanFit::quantization, &AllanFit::angle_random_walk, &AllanFit::flicker,         &AllanFit::rate_random_walk,
    &AllanFit::rate_ramp,    &AllanFit::markov_sigma,      &AllanFit::bias_instability};

void scale(AllanFit& fit, double factor) {
  for (const auto term : kDeviationTerms) {
    AllanCoefficient& c = fit.*term;
    c.value *= factor;
    c.low *= factor;
    c.high *= factor;
  }
  for (double& deviation : fit.deviation) deviation *= factor;
  for (auto& [low, high] : fit.ci95) {
    low *= factor;
    high *= factor;
  }
}

bool is_representable(const AllanFit& fit) {
  return std::all_of(kDeviationTerms.begin(), kDeviationTerms.end(), [&](const auto term) {
    const AllanCoefficient& c = fit.*term;
    return std::isfinite(c.high) && (!c.found || std::isnormal(c.value));
  });
}

/// The fit with or without a Markov term. Nothing where even the first step cannot be made.
std::optional<Fitted> fit_terms(const Points& points, const PairCounts& counts, const CovarianceTable& table,
                                Outliers outliers) {
  std::optional<Solution> plain = solve(points, counts, table, outliers);
  if (plain) {
    std::optional<Fitted> with_markov = fit_with_markov(points, counts, *plain, outliers);
    if (with_markov && (outliers == Outliers::down_weighted || !misfits(with_markov->solution))) return with_markov;
  }
  // The averaging times that a low-pass leaves tell little of what is white and what is flicker.
  std::optional<Fitted> rival;
  if (points.lag != 0.0) rival = fit_with_markov(points, counts, outliers);
  if (!plain) return rival;
  Fitted without{.table = table, .solution = std::move(*plain), .lag = points.lag};
  if (!rival) return without;
  return preferred(std::move(without), std::move(*rival));
}

/// The Markov term is tried before any averaging time counts less: what it explains must not pass for outliers.
std::optional<Fitted> fit_terms(const Points& points, const PairCounts& counts) {
  const CovarianceTable table(counts, points.multiples, 0.0);
  std::optional<Fitted> fit = fit_terms(points, counts, table, Outliers::kept);
  if (fit && !misfits(fit->solution)) return fit;
  return fit_terms(points, counts, table, Outliers::down_weighted);
}

double lag_of(const AllanCurve& curve) {
  return curve.low_pass ? LowPassCurve(*curve.low_pass, curve.interval_s).lag() : 0.0;
}

/// Takes the averaging times that the low-pass still shapes off the curve and returns them.
AllanCurve cut_within_low_pass(AllanCurve& curve) {
  AllanCurve shorter = curve;
  const double least = curve.low_pass ? kBeyondLowPass / (curve.low_pass->corner_hz * curve.interval_s) : 0.0;
  const auto first = std::partition_point(curve.multiples.begin(), curve.multiples.end(),
                                          [&](std::size_t m) { return static_cast<double>(m) < least; });
  const auto count = first - curve.multiples.begin();
  shorter.multiples.resize(static_cast<std::size_t>(count));
  shorter.deviation.resize(static_cast<std::size_t>(count));
  curve.multiples.erase(curve.multiples.begin(), first);
  curve.deviation.erase(curve.deviation.begin(), curve.deviation.begin() + count);
  return shorter;
}

tl::unexpected<base::Error> behind_low_pass_too_short(const LowPass& filter) {
  return base::bad_input(fmt::format("a fit needs at least 5 averaging times beyond {:.2g} s, {:g} periods of the "
                                     "unit's low-pass of {:.3g} Hz: the record is too short",
                                     kBeyondLowPass / filter.corner_hz, kBeyondLowPass, filter.corner_hz),
                         "multiples");
}

/// The same for the averaging times that the low-pass shapes: the white noise as the filter's form makes it, the other
/// terms as they are.
void add_shorter(const AllanCurve& shorter, const PairCounts& counts, const Fitted& fit, AllanFit& result) {
  const PerTerm theta = fit.solution.best().theta();
  std::vector<double> deviations;
  std::vector<double> freedoms;
  std::vector<std::array<double, 2>> ci95;
  for (std::size_t i = 0; i < shorter.multiples.size(); ++i) {
    const auto m = static_cast<double>(shorter.multiples[i]);
    const LowPassCurve::Point point = LowPassCurve(*shorter.low_pass, shorter.interval_s).at(m, counts.differences(m));
    PerTerm phi = allan_variances(m, fit.table.markov_time());
    phi[white] = point.variance;
    deviations.push_back(std::sqrt(std::inner_product(phi.begin(), phi.end(), theta.begin(), 0.0)));
    freedoms.push_back(std::max(1.0, point.degrees_of_freedom));
    ci95.push_back(interval(shorter.deviation[i], freedoms.back()));
  }
  result.first_fitted = deviations.size();
  result.deviation.insert(result.deviation.begin(), deviations.begin(), deviations.end());
  result.degrees_of_freedom.insert(result.degrees_of_freedom.begin(), freedoms.begin(), freedoms.end());
  result.ci95.insert(result.ci95.begin(), ci95.begin(), ci95.end());
}

}  // namespace

}  // namespace soak::calib::signal::allan_fit

namespace soak::calib::signal {

AllanCurve overlapping_curve(const PhaseRecord& record, std::span<const std::size_t> multiples) {
  AllanCurve curve;
  curve.interval_s = record.interval_s();
  for (const Stretch& stretch : record.stretches()) curve.stretches.push_back(stretch.count);
  curve.multiples.assign(multiples.begin(), multiples.end());
  for (const AllanPoint& point : allan_points(record, AllanKind::overlapping, multiples)) {
    curve.deviation.push_back(point.deviation);
  }
  return curve;
}

base::Result<AllanFit> fit_allan(const AllanCurve& measured) {
  using namespace allan_fit;
  if (const base::Status status = check_curve(measured); !status) return tl::unexpected(status.error());
  const double size = size_of(measured.deviation);
  AllanCurve curve = measured;
  for (double& deviation : curve.deviation) deviation /= size;
  const AllanCurve shorter = cut_within_low_pass(curve);
  if (curve.multiples.size() < kFewestPoints) return behind_low_pass_too_short(*curve.low_pass);
  const PairCounts counts(curve.stretches);
  const std::optional<Fitted> fit = fit_terms(thinned(curve, lag_of(curve)), counts);
  if (!fit) return base::bad_input("no sum of noise terms comes near this curve", "deviation");
  AllanFit result;
  add_curve(curve, *fit, result);
  add_intervals(curve, counts, *fit, result);
  add_coefficients(curve, *fit, result);
  add_shorter(shorter, counts, *fit, result);
  scale(result, size);
  if (!is_representable(result)) {
    return base::bad_input("coefficients of this curve are beyond the range of numbers: choose another unit",
                           "deviation");
  }
  result.p_value = misfit_probability(fit->solution);
  return result;
}

}  // namespace soak::calib::signal
