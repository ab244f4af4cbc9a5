// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace soak::calib::signal::allan_fit {
namespace {

double normal_probability(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

/// Standard normal equivalent of x in a Pearson type III distribution of mean 0, variance 1 and this skewness.
double normal_equivalent(double x, double skewness) {
  if (skewness < 1e-4) return x;
  // chi^2 = nu + sqrt(2 nu) x with nu = 8/skewness^2; (chi^2/nu)^(1/3) is normal, mean 1 - 2/(9 nu), variance 2/(9 nu)
  const double ratio = 1.0 + 0.5 * skewness * x;
  if (ratio <= 0.0) return -std::numeric_limits<double>::infinity();
  return 6.0 / skewness * (std::cbrt(ratio) - 1.0) + skewness / 6.0;
}

double truth_at_most(const VarianceEstimate& estimate, double t) {
  const auto& [constant, linear, square] = estimate.variance;
  const double variance = constant + t * (linear + t * square);
  if (variance <= 0.0) return t < estimate.value ? 0.0 : 1.0;
  const double sigma = std::sqrt(variance);
  // third central moment of t chi^2_nu/nu: 8 t^3/nu^2 = 2 square^2 t^3
  const double skewness = 2.0 * square * square * std::pow(t / sigma, 3);
  return normal_probability(-normal_equivalent((estimate.value - t) / sigma, skewness));
}

/// Neighbouring times make curves that differ by less than 10 %.
constexpr double kTimeRatio = 1.2;

}  // namespace

double ConfidenceDistribution::probability(double t) const {
  double without = 1.0;
  double sum = 0.0;
  for (const VarianceEstimate& estimate : estimates_) {
    without -= estimate.weight;
    sum += estimate.weight * truth_at_most(estimate, t);
  }
  return sum + std::max(0.0, without);
}

double ConfidenceDistribution::quantile(double p) const {
  if (estimates_.empty() || probability(0.0) >= p) return 0.0;
  double high = 0.0;
  for (const VarianceEstimate& estimate : estimates_) {
    high = std::max(high, std::abs(estimate.value) + std::sqrt(std::max(0.0, estimate.variance[0])));
  }
  constexpr double kBeyond = 1e6;
  const double end = kBeyond * high;
  while (probability(high) < p && high < end) high *= 2.0;
  double low = 0.0;
  for (int i = 0; i < 60 && high - low > 1e-7 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (probability(middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double relative_variance(const TermPairs& pairs, const PerTerm& theta, double allan_variance) {
  return quadratic_form(pairs, theta) / (allan_variance * allan_variance);
}

double power_law_relative_variance(const TermPairs& pairs, double m) {
  const PerTerm phi = allan_variances(m, 0.0);
  double largest = 0.0;
  for (const Term term : {white, flicker, random_walk}) {
    PerTerm alone{};
    alone[term] = 1.0;
    largest = std::max(largest, relative_variance(pairs, alone, phi[term]));
  }
  return largest;
}

double largest_theta(const UpperCurve& upper, Term term, double markov_time) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < upper.multiples.size(); ++i) {
    least = std::min(least, upper.variance[i] / allan_variances(upper.multiples[i], markov_time, upper.lag)[term]);
  }
  return least;
}

double largest_markov_theta(const UpperCurve& upper) {
  double largest = 0.0;
  for (double time = upper.multiples.front(); time <= upper.multiples.back(); time *= kTimeRatio) {
    largest = std::max(largest, largest_theta(upper, markov, time));
  }
  return largest;
}

}  // namespace soak::calib::signal::allan_fit
