// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/random.h"
#include "calib/signal/allan/allan.h"

// The Allan family word for word from its definition in means of the rate [NIST SP 1065 §5.2], with loops inside loops
// in extended precision, and gaps by their description in allan.h. Shares nothing with the product.
namespace soak::calib::signal::test {

/// The same number, or neither is one.
inline bool same_value(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Stretches of samples without a gap, short gaps filled by a straight line.
inline std::vector<std::vector<double>> stretches_without_gap(const std::vector<double>& rate, std::size_t bridge) {
  std::vector<std::vector<double>> stretches;
  std::size_t i = 0;
  while (i < rate.size()) {
    std::size_t end = i;
    while (end < rate.size() && std::isnan(rate[end])) ++end;
    if (end == rate.size()) break;
    const std::size_t gap = end - i;
    if (stretches.empty() || gap > bridge) stretches.emplace_back();
    std::vector<double>& stretch = stretches.back();
    const double before = stretch.empty() ? 0.0 : stretch.back();
    for (std::size_t k = 1; k <= gap && !stretch.empty(); ++k) {
      stretch.push_back(before + (rate[end] - before) * static_cast<double>(k) / static_cast<double>(gap + 1));
    }
    stretch.push_back(rate[end]);
    i = end + 1;
  }
  return stretches;
}

inline long double mean_of(const std::vector<double>& y, std::size_t first, std::size_t m) {
  long double sum = 0.0L;
  for (std::size_t i = first; i < first + m; ++i) sum += y[i];
  return sum / static_cast<long double>(m);
}

inline long double difference(const std::vector<double>& y, bool hadamard, std::size_t i, std::size_t m) {
  const long double first = mean_of(y, i, m);
  const long double second = mean_of(y, i + m, m);
  return hadamard ? mean_of(y, i + 2 * m, m) - 2.0L * second + first : second - first;
}

inline AllanPoint allan_by_definition(const std::vector<std::vector<double>>& stretches, AllanKind kind,
                                      std::size_t m) {
  const bool hadamard = kind == AllanKind::hadamard || kind == AllanKind::overlapping_hadamard;
  const bool overlap = kind != AllanKind::plain && kind != AllanKind::hadamard;
  const std::size_t windows = kind == AllanKind::modified ? m : 1;  // adjacent differences in one mean
  AllanPoint result{m, kMissing, 0};
  long double sum = 0.0L;
  for (const std::vector<double>& y : stretches) {
    for (std::size_t i = 0; i + (windows - 1) + (hadamard ? 3 : 2) * m <= y.size(); i += overlap ? 1 : m) {
      long double mean = 0.0L;
      for (std::size_t k = 0; k < windows; ++k) mean += difference(y, hadamard, i + k, m);
      mean /= static_cast<long double>(windows);
      sum += mean * mean;
      ++result.terms;
    }
  }
  if (result.terms > 0) {
    result.deviation =
        static_cast<double>(std::sqrt(sum / static_cast<long double>(result.terms) / (hadamard ? 6.0L : 2.0L)));
  }
  return result;
}

inline std::vector<double> gaussian_noise(std::size_t count, std::uint64_t seed) {
  base::Random random(seed);
  std::vector<double> noise(count);
  for (double& value : noise) value = random.gaussian();
  return noise;
}

/// Takes samples out: gaps of 1 to `longest`, on average one in `every` samples.
inline void make_gaps(std::vector<double>& rate, std::size_t every, std::size_t longest, std::uint64_t seed) {
  base::Random random(seed, 1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.uniform() * static_cast<double>(n)); };
  for (std::size_t i = below(2 * every); i < rate.size(); i += 1 + below(2 * every)) {
    for (std::size_t k = 1 + below(longest); k > 0 && i < rate.size(); --k, ++i) rate[i] = kMissing;
  }
}

constexpr AllanKind kAllKinds[] = {AllanKind::plain, AllanKind::overlapping, AllanKind::modified, AllanKind::hadamard,
                                   AllanKind::overlapping_hadamard};

}  // namespace soak::calib::signal::test
