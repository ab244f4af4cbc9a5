// SPDX-License-Identifier: Apache-2.0
#include "nav/outages/bootstrap.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "base/random.h"

namespace soak::nav {
namespace {

constexpr std::size_t kDraws = 2000;
constexpr std::size_t kFewestCases = 5;

}  // namespace

Estimate bootstrap(std::size_t count, const std::function<double(std::span<const std::size_t>)>& statistic,
                   std::uint64_t seed) {
  std::vector<std::size_t> cases(count);
  std::iota(cases.begin(), cases.end(), std::size_t{0});
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Estimate estimate{statistic(cases), kNone, kNone};
  if (count < kFewestCases) return estimate;
  base::Random random(seed);
  std::vector<double> drawn(kDraws);
  for (double& value : drawn) {
    for (std::size_t& index : cases) {
      index = std::min(count - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(count)));
    }
    value = statistic(cases);
  }
  std::ranges::sort(drawn);
  estimate.low = drawn[kDraws * 25 / 1000];
  estimate.high = drawn[kDraws * 975 / 1000];
  return estimate;
}

}  // namespace soak::nav
