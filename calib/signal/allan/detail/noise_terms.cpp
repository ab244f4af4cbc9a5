// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/noise_terms.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

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

/// Panels up to this many lags are summed lag by lag.
constexpr double kSummed = 24.0;
/// Each panel is this much longer than its neighbour nearer to the kink.
constexpr double kGrowth = 2.5;

constexpr std::array<double, 6> kNode = {-0.932469514203152, -0.661209386466265, -0.238619186083197,
                                         0.238619186083197,  0.661209386466265,  0.932469514203152};
constexpr std::array<double, 6> kWeight = {0.171324492379170, 0.360761573048139, 0.467913934572691,
                                           0.467913934572691, 0.360761573048139, 0.171324492379170};

constexpr std::size_t pair_index(std::size_t k, std::size_t l) { return k * (k + 1) / 2 + l; }

/// The sum over lags for one pair of averaging times, m_a <= m_b.
class LagSum {
 public:
  LagSum(const PairCounts& counts, double m_a, double m_b, double markov_time)
      : counts_(counts), m_a_(m_a), m_b_(m_b), markov_time_(markov_time) {}

  TermPairs total() {
    const std::vector<double> kinks = this->kinks();
    for (std::size_t i = 0; i + 1 < kinks.size(); ++i) add_between(kinks[i], kinks[i + 1]);
    for (const double u : kinks) add_comb(u);
    return sum_;
  }

 private:
  /// Where c_ab or n_ab has a kink, and the ends of the range of lags; rising, without repetition.
  [[nodiscard]] std::vector<double> kinks() const {
    const double first = -(counts_.longest() - 2.0 * m_a_);
    const double last = counts_.longest() - 2.0 * m_b_;
    std::vector<double> lags = {first, last};
    const auto add = [&](double u) {
      if (u > first && u < last) lags.push_back(u);
    };
    for (int p = 0; p < 3; ++p) {
      for (int q = 0; q < 3; ++q) add(p * m_a_ - q * m_b_);
    }
    std::sort(lags.begin(), lags.end());
    lags.erase(std::unique(lags.begin(), lags.end()), lags.end());
    return lags;
  }

  /// Panels between two kinks, growing from both towards the middle.
  void add_between(double from, double to) {
    double step = std::max(kSummed, markov_time_ > 0.0 ? std::min(m_a_, markov_time_) : m_a_);
    while (to - from > 2.0 * kGrowth * step) {
      step = std::floor(step);
      add_panel(from, from + step);
      add_panel(to - step, to);
      from += step;
      to -= step;
      step *= kGrowth;
    }
    add_panel(from, to);
  }

  /// Both ends count half: sum of the panels = sum over all lags (the outermost have no pairs).
  void add_panel(double from, double to) {
    if (to - from > kSummed) {
      const double half = 0.5 * (to - from);
      for (std::size_t i = 0; i < kNode.size(); ++i) add_lag(from + half * (1.0 + kNode[i]), half * kWeight[i]);
      return;
    }
    for (double u = from; u <= to; ++u) add_lag(u, u == from || u == to ? 0.5 : 1.0);
  }

  void add_lag(double u, double weight) {
    const double n = weight * counts_.pairs(m_a_, m_b_, u);
    if (n <= 0.0) return;
    const PerTerm c = difference_covariances(m_a_, m_b_, u, markov_time_);
    for (std::size_t k = white; k < kTerms; ++k) {
      for (std::size_t l = white; l <= k; ++l) sum_[pair_index(k, l)] += n * c[k] * c[l];
    }
  }

  /// Quantization has covariance at the kinks only, and all of it there.
  void add_comb(double u) {
    const double n = counts_.pairs(m_a_, m_b_, u);
    const double comb = quantization_comb(m_a_, m_b_, u);
    if (n <= 0.0 || comb == 0.0) return;
    const PerTerm c = difference_covariances(m_a_, m_b_, u, markov_time_);
    sum_[pair_index(quantization, quantization)] += n * comb * comb;
    for (std::size_t k = white; k < kTerms; ++k) sum_[pair_index(k, quantization)] += n * c[k] * comb;
  }

  const PairCounts& counts_;
  double m_a_;
  double m_b_;
  double markov_time_;
  TermPairs sum_{};
};

}  // namespace

PerTerm allan_variances(double m, double markov_time, double lag) {
  PerTerm phi{};
  phi[quantization] = 3.0 / (m * m);
  phi[white] = 1.0 / m - 1.5 * lag / (m * m);
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

PairCounts::PairCounts(std::span<const std::size_t> stretches) {
  for (const std::size_t n : stretches) lengths_.push_back(static_cast<double>(n));
  std::sort(lengths_.begin(), lengths_.end());
  sums_ = lengths_;
  for (std::size_t k = sums_.size(); k-- > 1;) sums_[k - 1] += sums_[k];
}

double PairCounts::pairs(double m_a, double m_b, double u) const {
  // 0 <= i < n - 2 m_a and 0 <= i + u < n - 2 m_b
  return longer_than(std::max(2.0 * m_a, 2.0 * m_b + u) + std::max(0.0, -u));
}

double PairCounts::longer_than(double w) const {
  const auto first = std::upper_bound(lengths_.begin(), lengths_.end(), w);
  if (first == lengths_.end()) return 0.0;
  const auto k = static_cast<std::size_t>(first - lengths_.begin());
  return sums_[k] - w * static_cast<double>(lengths_.size() - k);
}

TermPairs covariance_terms(const PairCounts& counts, double m_a, double m_b, double markov_time) {
  if (m_a > m_b) std::swap(m_a, m_b);
  TermPairs pairs = LagSum(counts, m_a, m_b, markov_time).total();
  const double scale = 2.0 / (4.0 * m_a * m_a * m_b * m_b * counts.differences(m_a) * counts.differences(m_b));
  for (std::size_t k = 0; k < kTerms; ++k) {
    for (std::size_t l = 0; l <= k; ++l) pairs[pair_index(k, l)] *= k == l ? scale : 2.0 * scale;
  }
  pairs[pair_index(ramp, ramp)] = 0.0;
  return pairs;
}

double quadratic_form(const TermPairs& pairs, const PerTerm& theta) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kTerms; ++k) {
    for (std::size_t l = 0; l <= k; ++l) sum += pairs[pair_index(k, l)] * theta[k] * theta[l];
  }
  return sum;
}

CovarianceTable::CovarianceTable(const PairCounts& counts, std::vector<double> multiples, double markov_time)
    : multiples_(std::move(multiples)), markov_time_(markov_time) {
  for (std::size_t a = 0; a < multiples_.size(); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      entries_.push_back(covariance_terms(counts, multiples_[b], multiples_[a], markov_time_));
    }
  }
}

Eigen::MatrixXd CovarianceTable::covariance(const PerTerm& theta) const {
  const auto n = static_cast<Eigen::Index>(multiples_.size());
  Eigen::MatrixXd v(n, n);
  std::size_t entry = 0;
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b <= a; ++b) v(a, b) = v(b, a) = quadratic_form(entries_[entry++], theta);
  }
  return v;
}

}  // namespace soak::calib::signal::allan_fit
