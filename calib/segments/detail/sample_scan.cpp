// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/sample_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/instruction_set.h"

namespace soak::calib {
namespace {

constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;

/// Sum of term(0) ... term(n − 1), the lanes in turn to the end.
template <class Term>
SOAK_INLINE double lane_sum(std::size_t n, const Term& term) {
  Lanes partial{};
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) partial[lane] += term(i + lane);
  }
  for (std::size_t lane = 0; i < n; ++i, ++lane) partial[lane] += term(i);
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

/// Calls add(i, lane) for i = 0..n − 1, the lanes in turn as long as there is a whole round, then the first.
template <class Add>
SOAK_INLINE void for_lanes(std::size_t n, const Add& add) {
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) add(i + lane, lane);
  }
  for (; i < n; ++i) add(i, 0);
}

SOAK_CLONES
double scan_sum(const double* values, std::size_t n, double origin) {
  return lane_sum(n, [&](std::size_t i) { return values[i] - origin; });
}

SOAK_CLONES
double scan_squares(const double* values, std::size_t n, double centre) {
  return lane_sum(n, [&](std::size_t i) { return (values[i] - centre) * (values[i] - centre); });
}

SOAK_CLONES
double scan_gaps(const double* values, std::size_t n) {
  return lane_sum(n, [&](std::size_t i) { return values[i] != values[i] ? 1.0 : 0.0; });
}

/// The divisions do not wait for each other; the additions do.
SOAK_CLONES
void scan_quotients(const double* x, const double* y, std::size_t count, double n, double* sums) {
  double sum_x = sums[0];
  double sum_y = sums[1];
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    Lanes qx;
    Lanes qy;
    for (std::size_t lane = 0; lane < kLanes; ++lane) qx[lane] = x[i + lane] / n;
    for (std::size_t lane = 0; lane < kLanes; ++lane) qy[lane] = y[i + lane] / n;
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum_x += qx[lane];
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum_y += qy[lane];
  }
  for (; i < count; ++i) {
    sum_x += x[i] / n;
    sum_y += y[i] / n;
  }
  sums[0] = sum_x;
  sums[1] = sum_y;
}

SOAK_CLONES
void scan_minutes(const double* t_s, std::size_t n, double start_s, double* minutes) {
  for (std::size_t i = 0; i < n; ++i) minutes[i] = (t_s[i] - start_s) / 60.0;
}

SOAK_CLONES
void scan_deviations(const double* x, std::size_t n, double level, Lanes& sum, Lanes& peak) {
  Lanes s{};
  Lanes p{};
  for_lanes(n, [&](std::size_t i, std::size_t lane) {
    const double d = x[i] - level;
    const double size = std::abs(d);
    s[lane] += d;
    p[lane] = size > p[lane] ? size : p[lane];
  });
  sum = s;
  peak = p;
}

SOAK_CLONES
void scan_changes(const double* x, std::size_t n, Lanes& none, Lanes& smallest) {
  Lanes e{};
  Lanes m = smallest;
  for_lanes(n, [&](std::size_t i, std::size_t lane) {
    const double d = std::abs(x[i + 1] - x[i]);
    e[lane] += d == 0.0 ? 1.0 : 0.0;
    const double change = d == 0.0 ? std::numeric_limits<double>::infinity() : d;
    m[lane] = change < m[lane] ? change : m[lane];
  });
  none = e;
  smallest = m;
}

SOAK_CLONES
void scan_extremes(const double* x, std::size_t n, Lanes& low, Lanes& high) {
  Lanes l = low;
  Lanes h = high;
  for_lanes(n, [&](std::size_t i, std::size_t lane) {
    l[lane] = x[i] < l[lane] ? x[i] : l[lane];
    h[lane] = x[i] > h[lane] ? x[i] : h[lane];
  });
  low = l;
  high = h;
}

double total_of(const Lanes& lanes) { return std::accumulate(lanes.begin(), lanes.end(), 0.0); }

}  // namespace

double sum_above(std::span<const double> values, double origin) {
  return scan_sum(values.data(), values.size(), origin);
}

double squares_about(std::span<const double> values, double centre) {
  return scan_squares(values.data(), values.size(), centre);
}

bool has_gap(std::span<const double> values) { return scan_gaps(values.data(), values.size()) > 0.0; }

void add_quotients(std::span<const double> x, std::span<const double> y, double n, double& sum_x, double& sum_y) {
  std::array<double, 2> sums = {sum_x, sum_y};
  scan_quotients(x.data(), y.data(), x.size(), n, sums.data());
  sum_x = sums[0];
  sum_y = sums[1];
}

void minutes_since(std::span<const double> t_s, double start_s, std::span<double> minutes) {
  scan_minutes(t_s.data(), t_s.size(), start_s, minutes.data());
}

std::vector<double> thinned(std::span<const double> values, std::size_t most) {
  const std::size_t stride = values.size() / most + 1;
  std::vector<double> result;
  result.reserve(std::min(most + 1, values.size()));
  for (std::size_t i = 0; i < values.size(); i += stride) {
    std::size_t row = i;
    while (row + 1 < std::min(i + stride, values.size()) && std::isnan(values[row])) ++row;
    if (!std::isnan(values[row])) result.push_back(values[row]);
  }
  return result;
}

void Thinner::add(std::span<const double> values) {
  for (std::size_t i = 0; i < values.size();) {
    if (to_next_ == 0) {
      to_next_ = stride_;
      open_ = true;
    }
    const std::size_t end = i + std::min(to_next_, values.size() - i);
    to_next_ -= end - i;
    for (; open_ && i < end; ++i) {
      if (std::isnan(values[i])) continue;
      taken_.push_back(values[i]);
      open_ = false;
    }
    i = end;
  }
}

Deviation deviation_from(std::span<const double> values, double level) {
  Lanes sum{};
  Lanes peak{};
  scan_deviations(values.data(), values.size(), level, sum, peak);
  return {total_of(sum), std::ranges::max(peak)};
}

Changes changes_of(std::span<const double> values) {
  if (values.size() < 2) return {};
  Lanes none{};
  Lanes smallest;
  smallest.fill(std::numeric_limits<double>::infinity());
  scan_changes(values.data(), values.size() - 1, none, smallest);
  const double change = std::ranges::min(smallest);
  return {static_cast<std::size_t>(total_of(none)), std::isfinite(change) ? change : 0.0};
}

Extremes extremes_of(std::span<const double> values) {
  Lanes low;
  low.fill(values.front());
  Lanes high = low;
  scan_extremes(values.data(), values.size(), low, high);
  return {std::ranges::min(low), std::ranges::max(high)};
}

}  // namespace soak::calib
