// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/instruction_set.h"

namespace soak::calib::gate {
namespace {

constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;

/// Calls add(i, lane) for i = 0..n - 1, the lanes in turn.
template <class Add>
SOAK_INLINE void for_lanes(std::size_t n, const Add& add) {
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) add(i + lane, lane);
  }
  for (; i < n; ++i) add(i, 0);
}

SOAK_CLONES
void add_deviations(const double* x, std::size_t n, double level, Lanes& sum, Lanes& peak) {
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
void add_changes(const double* x, std::size_t n, Lanes& none, Lanes& smallest) {
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
void add_extremes(const double* x, std::size_t n, Lanes& low, Lanes& high) {
  Lanes l = low;
  Lanes h = high;
  for_lanes(n, [&](std::size_t i, std::size_t lane) {
    l[lane] = x[i] < l[lane] ? x[i] : l[lane];
    h[lane] = x[i] > h[lane] ? x[i] : h[lane];
  });
  low = l;
  high = h;
}

double total(const Lanes& lanes) { return std::accumulate(lanes.begin(), lanes.end(), 0.0); }
double least(const Lanes& lanes) { return *std::min_element(lanes.begin(), lanes.end()); }
double most(const Lanes& lanes) { return *std::max_element(lanes.begin(), lanes.end()); }

}  // namespace

Deviation deviation_from(std::span<const double> values, double level) {
  Lanes sum{};
  Lanes peak{};
  add_deviations(values.data(), values.size(), level, sum, peak);
  return {total(sum), most(peak)};
}

Changes changes_of(std::span<const double> values) {
  if (values.size() < 2) return {};
  Lanes none{};
  Lanes smallest;
  smallest.fill(std::numeric_limits<double>::infinity());
  add_changes(values.data(), values.size() - 1, none, smallest);
  const double change = least(smallest);
  return {static_cast<std::size_t>(total(none)), std::isfinite(change) ? change : 0.0};
}

Extremes extremes_of(std::span<const double> values) {
  Lanes low;
  low.fill(values.front());
  Lanes high = low;
  add_extremes(values.data(), values.size(), low, high);
  return {least(low), most(high)};
}

}  // namespace soak::calib::gate
