// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/limits.h"

#include <algorithm>
#include <limits>

namespace soak::calib::signal::allan_fit {
namespace {

/// Neighbouring times make curves that differ by less than 10 %.
constexpr double kTimeRatio = 1.2;

}  // namespace

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
    least = std::min(least, upper.variance[i] / allan_variances(upper.multiples[i], markov_time)[term]);
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
