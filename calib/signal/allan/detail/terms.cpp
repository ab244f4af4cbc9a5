// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/terms.h"

#include <cmath>
#include <numbers>

namespace soak::calib::signal::allan_fit {
namespace {

constexpr std::array<double, 3> kSecondDifference = {1.0, -2.0, 1.0};

double markov_allan_variance(double x) {
  if (x < 1e-4) return 2.0 * x / 3.0 - 0.5 * x * x;
  const double e = std::expm1(-x);
  // 3 - 4 exp(-x) + exp(-2 x) = e (e - 2), e = exp(-x) - 1
  return 2.0 / x * (1.0 - e * (e - 2.0) / (2.0 * x));
}

// Below: D f(t) = f(t + m) - 2 f(t) + f(t - m), written such that nothing cancels far from t = 0.

double second_difference_abs(double t, double m) { return 2.0 * std::max(0.0, m - std::abs(t)); }

double second_difference_cube(double t, double m) {
  const double a = std::abs(t);
  return a >= m ? 6.0 * a * m * m : 2.0 * m * m * m + 6.0 * m * a * a - 2.0 * a * a * a;
}

double square_times_log(double t) { return t == 0.0 ? 0.0 : t * t * std::log(std::abs(t)); }

double second_difference_square_log(double t, double m) {
  if (std::abs(t) < 16.0 * m) return square_times_log(t + m) - 2.0 * square_times_log(t) + square_times_log(t - m);
  // Taylor: f'' = 2 ln t + 3, f'''' = -2/t^2, f^(6) = -12/t^4
  const double r = m * m / (t * t);
  return m * m * (2.0 * std::log(std::abs(t)) + 3.0 - r / 6.0 - r * r / 30.0);
}

/// Of exp(-|t|/T) + |t|/T.
double second_difference_markov(double t, double m, double time) {
  const double a = std::abs(t);
  if (a >= m) return std::exp((m - a) / time) * std::pow(std::expm1(-m / time), 2);
  return std::exp(-(m + a) / time) + std::exp((a - m) / time) - 2.0 * std::exp(-a / time) + 2.0 * (m - a) / time;
}

}  // namespace

PerTerm allan_variances(double m, double markov_time) {
  PerTerm phi{};
  phi[quantization] = 3.0 / (m * m);
  phi[white] = 1.0 / m;
  phi[flicker] = 2.0 * std::numbers::ln2 / std::numbers::pi;
  phi[random_walk] = m / 3.0;
  phi[ramp] = 0.5 * m * m;
  if (markov_time > 0.0) phi[markov] = markov_allan_variance(m / markov_time);
  return phi;
}

PerTerm difference_covariances(double m_a, double m_b, double u, double markov_time) {
  PerTerm c{};
  for (std::size_t q = 0; q < 3; ++q) {
    const double t = u + static_cast<double>(q) * m_b - m_a;
    const double k = kSecondDifference[q];
    c[white] -= k * second_difference_abs(t, m_a) / 2.0;
    c[flicker] += k * second_difference_square_log(t, m_a) / (2.0 * std::numbers::pi);
    c[random_walk] += k * second_difference_cube(t, m_a) / 12.0;
    if (markov_time > 0.0) {
      c[markov] -= k * markov_time * markov_time * second_difference_markov(t, m_a, markov_time);
    }
  }
  c[ramp] = m_a * m_a * m_b * m_b;
  return c;
}

double quantization_comb(double m_a, double m_b, double u) {
  double c = 0.0;
  for (std::size_t p = 0; p < 3; ++p) {
    for (std::size_t q = 0; q < 3; ++q) {
      const double t = u + static_cast<double>(q) * m_b - static_cast<double>(p) * m_a;
      if (t == 0.0) c += kSecondDifference[p] * kSecondDifference[q];
    }
  }
  return c;
}

}  // namespace soak::calib::signal::allan_fit
