// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/sample_facts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr std::size_t kMostLooked = 20000;
constexpr std::size_t kLeastStuck = 10;
constexpr double kStuckRatio = 10.0;
constexpr double kGaussian = 1.4826 / 1.4142135623730951;  ///< median |difference| to standard deviation

std::vector<double> chosen(std::span<const double> samples) {
  const std::size_t stride = samples.size() / kMostLooked + 1;
  std::vector<double> values;
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    if (std::isfinite(samples[i])) values.push_back(samples[i]);
  }
  return values;
}

double noise_of(std::span<const double> samples) {
  std::vector<double> steps;
  const std::size_t stride = samples.size() / kMostLooked + 1;
  for (std::size_t i = 0; i + 1 < samples.size(); i += stride) {
    if (std::isfinite(samples[i]) && std::isfinite(samples[i + 1]))
      steps.push_back(std::abs(samples[i + 1] - samples[i]));
  }
  return steps.empty() ? 0.0 : kGaussian * base::median(steps);
}

std::optional<double> lattice_step(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() < 3) return std::nullopt;
  const double rounding = 1e-9 * std::max(std::abs(values.front()), std::abs(values.back()));
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double gap = values[i] - values[i - 1];
    if (gap > rounding) step = std::min(step, gap);
  }
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double steps = (values[i] - values[i - 1]) / step;
    if (std::abs(steps - std::round(steps)) > 0.02) return std::nullopt;
  }
  return step;
}

/// Samples at the extreme value, or 0 where the value next to it has nearly as many.
std::size_t stuck_at(std::span<const double> samples, double extreme, bool highest) {
  std::size_t count = 0;
  double next = highest ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  std::size_t at_next = 0;
  for (const double value : samples) {
    if (!std::isfinite(value)) continue;
    if (value == extreme) {
      ++count;
    } else if (value == next) {
      ++at_next;
    } else if (highest ? value > next : value < next) {
      next = value;
      at_next = 1;
    }
  }
  const bool stuck = count >= kLeastStuck && static_cast<double>(count) > kStuckRatio * static_cast<double>(at_next);
  return stuck && at_next > 0 ? count : 0;
}

}  // namespace

void SampleFacts::add(const SampleFacts& other) {
  if (other.count == 0) return;
  if (count == 0) {
    *this = other;
    return;
  }
  count += other.count;
  step = step && other.step ? std::optional(std::max(*step, *other.step)) : std::nullopt;
  noise = std::min(noise, other.noise);
  low_rail = std::min(low_rail, other.low_rail);
  high_rail = std::max(high_rail, other.high_rail);
  at_rails += other.at_rails;
}

SampleFacts sample_facts(std::span<const double> samples) {
  SampleFacts facts;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : samples) {
    if (!std::isfinite(value)) continue;
    ++facts.count;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (facts.count == 0) return facts;
  facts.low_rail = low;
  facts.high_rail = high;
  facts.noise = noise_of(samples);
  facts.step = lattice_step(chosen(samples));
  facts.at_rails = stuck_at(samples, low, false) + stuck_at(samples, high, true);
  return facts;
}

}  // namespace soak::calib::gap
