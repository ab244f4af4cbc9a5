// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/documents/detail/bridging.h"

#include <algorithm>
#include <cmath>

#include "calib/signal/samples/sample_grid.h"

namespace soak::calib::signal_json {
namespace {

constexpr double kModelError = 1e-3;
constexpr double kFewestSamples = 10.0;

}  // namespace

bool Bridging::negligible() const {
  return excess <= std::max(kModelError, 0.25 * std::sqrt(3.0 / static_cast<double>(samples)));
}

std::size_t Bridging::first_multiple() const {
  // 2 excess/m = sqrt(4 m/(3 samples))/4
  const double m = std::cbrt(48.0 * excess * excess * static_cast<double>(samples));
  return static_cast<std::size_t>(std::ceil(std::max(kFewestSamples, m)));
}

Bridging bridging(std::span<const double> values, std::size_t longest) {
  const auto ranges = signal::stretches_of(values);
  Bridging result;
  double added = 0.0;
  std::size_t bridged = 0;
  std::size_t before = 0;
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    const std::size_t gap = r + 1 < ranges.size() ? ranges[r + 1].first - ranges[r].last : longest + 1;
    const std::size_t after = gap <= longest ? gap : 0;
    const auto add = [&](std::size_t neighbours) {
      const double w = 1.0 + 0.5 * static_cast<double>(neighbours);
      added += w * w - w;
    };
    // A sample alone between two gaps carries both.
    if (ranges[r].count() == 1) {
      add(before + after);
    } else {
      add(before);
      add(after);
    }
    result.samples += ranges[r].count() + after;
    bridged += after;
    before = after;
  }
  if (result.samples == 0) return result;
  result.share = static_cast<double>(bridged) / static_cast<double>(result.samples);
  result.excess = added / static_cast<double>(result.samples);
  return result;
}

}  // namespace soak::calib::signal_json
