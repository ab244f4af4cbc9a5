// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/campaign/campaign.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr std::size_t kMostLooked = 20000;
constexpr std::size_t kLeastStuck = 10;
constexpr double kStuckRatio = 10.0;
constexpr double kLowerShare = 0.5627;
constexpr double kFewSteps = 20.0;

std::vector<double> chosen(std::span<const double> samples) {
  const std::size_t stride = samples.size() / kMostLooked + 1;
  std::vector<double> values;
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    if (std::isfinite(samples[i])) values.push_back(samples[i]);
  }
  return values;
}

/// From the squares of the differences between neighbours, the largest tenth left out: turns are no noise. On a lattice
/// of coarse steps a median would be 0.
double noise_of(std::span<const double> samples) {
  std::vector<double> squares;
  const std::size_t stride = samples.size() / kMostLooked + 1;
  for (std::size_t i = 0; i + 1 < samples.size(); i += stride) {
    const double difference = samples[i + 1] - samples[i];
    if (std::isfinite(difference)) squares.push_back(difference * difference);
  }
  if (squares.empty()) return 0.0;
  const std::size_t kept = squares.size() - squares.size() / 10;
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(kept - 1), squares.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
  // Of a Gaussian, the lower nine tenths of the squares hold 0.5627 of their mean.
  return std::sqrt(0.5 * sum / static_cast<double>(squares.size()) / kLowerShare);
}

/// Numbers are printed with so many digits after the point that all are multiples of the resolution.
double text_resolution(const std::vector<double>& values) {
  for (double resolution = 1e-3; resolution > 1e-12; resolution *= 0.1) {
    const bool fits = std::all_of(values.begin(), values.end(), [&](double value) {
      const double steps = value / resolution;
      return std::abs(steps - std::round(steps)) < 1e-3;
    });
    if (fits) return resolution;
  }
  return 0.0;
}

/// Gaps between neighbouring distinct values are counted in steps, beginning with the smallest as the step and refining
/// it by all gaps of few steps; the larger ones then have to be whole within the resolution of the text.
std::optional<double> lattice_step(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() < 3) return std::nullopt;
  const double resolution = text_resolution(values);
  const double least = std::max(1.5 * resolution, 1e-9 * std::max(std::abs(values.front()), std::abs(values.back())));
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double gap = values[i] - values[i - 1];
    if (gap > least) step = std::min(step, gap);
  }
  if (!std::isfinite(step)) return std::nullopt;
  double length = 0.0;
  double steps = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double count = std::round((values[i] - values[i - 1]) / step);
    if (count < 1.0 || count > kFewSteps) continue;
    length += values[i] - values[i - 1];
    steps += count;
  }
  step = length / steps;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double gap = values[i] - values[i - 1];
    if (gap > kFewSteps * step) continue;  // from position to position: too many steps to count
    if (std::abs(gap - step * std::round(gap / step)) > 0.02 * step + 1.1 * resolution) return std::nullopt;
  }
  // Digits alone are no output step.
  return step > 1.5 * resolution ? std::optional(step) : std::nullopt;
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

constexpr double kBin_s = 10.0;

double bin_length_s(const std::vector<double>& t_s) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t_s.size(); ++i) steps.push_back(t_s[i] - t_s[i - 1]);
  return steps.empty() ? kBin_s : std::max(kBin_s, base::median(steps));
}

/// First row of each bin, and one past the last row.
std::vector<std::size_t> bin_edges(const std::vector<double>& t_s, double length_s) {
  std::vector<std::size_t> edges;
  double bin = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    const double here = std::floor((t_s[i] - t_s.front()) / length_s);
    if (here > bin) edges.push_back(i);
    bin = here;
  }
  edges.push_back(t_s.size());
  return edges;
}

std::vector<double> means(const std::vector<double>& values, const std::vector<std::size_t>& edges) {
  std::vector<double> result;
  if (values.empty()) return result;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = edges[k]; i < edges[k + 1]; ++i) {
      if (!std::isfinite(values[i])) continue;
      sum += values[i];
      count += 1.0;
    }
    result.push_back(count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

std::vector<double> auxiliary(const Recording& recording, std::string_view name,
                              const std::vector<std::size_t>& edges) {
  for (const AuxiliaryChannel& channel : recording.auxiliary) {
    if (channel.name == name) return means(channel.values, edges);
  }
  return {};
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
  // The outermost codes of a coarse lattice look like rails.
  if (facts.step && *facts.step > facts.noise) return facts;
  facts.at_rails = stuck_at(samples, low, false) + stuck_at(samples, high, true);
  return facts;
}

RunLog make_run_log(const Recording& recording) {
  RunLog log;
  if (recording.t_s.empty()) return log;
  const auto edges = bin_edges(recording.t_s, bin_length_s(recording.t_s));
  log.t_s = means(recording.t_s, edges);
  log.temp_c = means(recording.temp_c, edges);
  log.t_since_power_s = means(recording.t_since_power_s, edges);
  if (log.t_since_power_s.empty()) {
    for (const double t_s : log.t_s) log.t_since_power_s.push_back(t_s - recording.t_s.front());
  }
  log.chamber_c = auxiliary(recording, "chamber_c", edges);
  log.compressor = auxiliary(recording, "compressor", edges);
  log.supply_v = auxiliary(recording, "supply_v", edges);
  return log;
}

bool has_plateaus(const LoggedCampaign& campaign) {
  return std::ranges::any_of(campaign.runs, [](const LoggedRun& run) {
    return std::ranges::any_of(run.run.segments, [](const Segment& segment) {
      return segment.phase == Phase::soak && segment.plateau_c.has_value();
    });
  });
}

}  // namespace soak::calib::gap
