// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/plateaus.h"

#include <algorithm>
#include <cmath>

namespace soak::calib {
namespace {

constexpr double kMean_s = 10.0;
constexpr double kShortest_s = 180.0;
constexpr double kBand_c = 0.6;
constexpr double kSameLevel_c = 1.0;

/// Mean temperature of the rows [first, last), all within ten seconds.
struct ShortMean {
  std::size_t first;
  std::size_t last;
  double start_s;
  double end_s;
  double temp_c;
};

std::vector<ShortMean> short_means(std::span<const double> t_s, std::span<const double> temp_c) {
  std::vector<ShortMean> means;
  std::size_t first = 0;
  while (first < t_s.size()) {
    std::size_t last = first;
    double sum = 0.0;
    std::size_t count = 0;
    for (; last < t_s.size() && (last == first || t_s[last] - t_s[first] < kMean_s); ++last) {
      if (std::isnan(temp_c[last])) continue;
      sum += temp_c[last];
      ++count;
    }
    if (count > 0) means.push_back({first, last, t_s[first], t_s[last - 1], sum / static_cast<double>(count)});
    first = last;
  }
  return means;
}

/// Number of short means from `start` on that stay within the band.
std::size_t still_length(const std::vector<ShortMean>& means, std::size_t start) {
  double low = means[start].temp_c;
  double high = low;
  std::size_t i = start;
  for (; i < means.size(); ++i) {
    low = std::min(low, means[i].temp_c);
    high = std::max(high, means[i].temp_c);
    if (high - low > kBand_c) break;
  }
  return i - start;
}

Plateau plateau_of(const std::vector<ShortMean>& means, std::size_t start, std::size_t length) {
  double sum = 0.0;
  for (std::size_t i = start; i < start + length; ++i) sum += means[i].temp_c;
  return {means[start].first, means[start + length - 1].last, sum / static_cast<double>(length)};
}

/// A stretch follows another without a step when no time to speak of lies between them.
bool follows(std::span<const double> t_s, const Plateau& before, const Plateau& after) {
  return t_s[after.first] - t_s[before.last - 1] <= 3.0 * kMean_s;
}

}  // namespace

std::vector<Plateau> find_plateaus(std::span<const double> t_s, std::span<const double> temp_c) {
  const std::vector<ShortMean> means = short_means(t_s, temp_c);
  std::vector<Plateau> still;
  for (std::size_t start = 0; start < means.size();) {
    const std::size_t length = still_length(means, start);
    const bool long_enough = means[start + length - 1].end_s - means[start].start_s >= kShortest_s;
    if (!long_enough) {
      ++start;
      continue;
    }
    const Plateau found = plateau_of(means, start, length);
    if (!still.empty() && std::abs(still.back().temp_c - found.temp_c) < kSameLevel_c &&
        follows(t_s, still.back(), found)) {
      const double n = static_cast<double>(still.back().last - still.back().first);
      const double m = static_cast<double>(found.last - found.first);
      still.back().temp_c = (n * still.back().temp_c + m * found.temp_c) / (n + m);
      still.back().last = found.last;
    } else {
      still.push_back(found);
    }
    start += length;
  }
  // Whatever joins the next without a step between, and differs from it, is part of a slow ramp.
  std::vector<Plateau> plateaus;
  for (std::size_t i = 0; i < still.size(); ++i) {
    const bool joins_next = i + 1 < still.size() && follows(t_s, still[i], still[i + 1]);
    const bool joins_previous = i > 0 && follows(t_s, still[i - 1], still[i]);
    if (!joins_next && !joins_previous) plateaus.push_back(still[i]);
  }
  return plateaus;
}

}  // namespace soak::calib
