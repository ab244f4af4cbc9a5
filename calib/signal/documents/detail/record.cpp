// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/documents/detail/record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/statistics.h"
#include "calib/signal/allan/allan.h"
#include "calib/signal/samples/sample_grid.h"

namespace soak::calib::signal_json {
namespace {

constexpr double kModelError = 1e-3;
constexpr double kFewestSamples = 10.0;

using signal::SampleRange;

/// 1/0.6745: standard deviation of normal numbers over their median absolute value.
constexpr double kSigmaPerMedian = 1.4826;
constexpr double kOutlier = 8.0;
/// Difference of window means over its robust standard deviation. Of 3840 simulated records (600 to 100,000 samples) of
/// white, flicker, random walk and mixed noise the largest was 6.0.
constexpr double kStep = 7.0;
constexpr std::size_t kNeighbours = 5;
constexpr std::size_t kBlocksPerWindow = 4;
/// Shorter ones show single samples and steps of the quantisation.
constexpr std::size_t kLeastBlock = 5;

/// So many differences give their median to 0.1 %.
constexpr std::size_t kMostDifferences = 1'000'000;

/// Absolute first differences within the stretches: every k-th, so that at most about kMostDifferences are kept.
std::vector<double> absolute_differences(std::span<const double> values) {
  const std::size_t step = 1 + values.size() / kMostDifferences;
  std::vector<double> differences;
  differences.reserve(values.size() / step + 1);
  for (std::size_t i = 1; i < values.size(); i += step) {
    const double difference = std::abs(values[i] - values[i - 1]);
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  return differences;
}

/// The smallest first difference that is not 0: one step of the quantisation, where it is coarse.
double least_difference(std::span<const double> values) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double difference = std::abs(values[i] - values[i - 1]);
    if (difference > 0.0) least = std::min(least, difference);
  }
  return least;
}

double root_mean_square(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Robust standard deviation of numbers about 0, given their absolute values. Coarsely quantised ones are mostly 0.
double robust_sigma(std::span<const double> absolute) {
  const double median = base::median(absolute);
  return median > 0.0 ? kSigmaPerMedian * median : root_mean_square(absolute);
}

/// Median of the five values of the stretch that are nearest to sample i.
double local_median(std::span<const double> values, const SampleRange& stretch, std::size_t i) {
  const std::size_t half = kNeighbours / 2;
  const std::size_t first = std::clamp(i, stretch.first + half, stretch.last - 1 - half) - half;
  std::array<double, kNeighbours> near{};
  std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first), kNeighbours, near.begin());
  std::nth_element(near.begin(), near.begin() + half, near.end());
  return near[half];
}

/// Means over the blocks of a stretch, the rest at its end left out.
std::vector<double> block_means(std::span<const double> values, const SampleRange& stretch, std::size_t block) {
  std::vector<double> means;
  for (std::size_t first = stretch.first; first + block <= stretch.last; first += block) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + block; ++i) sum += values[i] - values[stretch.first];
    means.push_back(values[stretch.first] + sum / static_cast<double>(block));
  }
  return means;
}

/// Of the windows behind and before the block, in the mean.
double window_difference(std::span<const double> means, std::size_t block) {
  double difference = 0.0;
  for (std::size_t k = 0; k < kBlocksPerWindow; ++k) difference += means[block + k] - means[block - 1 - k];
  return difference / static_cast<double>(kBlocksPerWindow);
}

struct Contrast {
  Step step;
  double sigmas = 0.0;
};

/// The largest difference of windows of four such blocks.
Contrast contrast(std::span<const double> values, std::span<const SampleRange> stretches, std::size_t block) {
  Contrast found;
  std::vector<double> absolute;
  for (const SampleRange& stretch : stretches) {
    const std::vector<double> means = block_means(values, stretch, block);
    for (std::size_t b = kBlocksPerWindow; b + kBlocksPerWindow <= means.size(); ++b) {
      const double difference = window_difference(means, b);
      absolute.push_back(std::abs(difference));
      if (std::abs(difference) > std::abs(found.step.height)) found.step = {stretch.first + b * block, difference};
    }
  }
  if (found.step.height != 0.0) found.sigmas = std::abs(found.step.height) / robust_sigma(absolute);
  return found;
}

}  // namespace

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json numbers(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

json header(const SignalRecord& record) {
  const auto missing =
      std::count_if(record.values.begin(), record.values.end(), [](double v) { return std::isnan(v); });
  return {{"column", record.column},
          {"unit", record.unit},
          {"rate_hz", record.rate_hz},
          {"samples", record.values.size() - static_cast<std::size_t>(missing)},
          {"missing", missing}};
}

std::size_t longest_stretch(const std::vector<double>& values) {
  std::size_t longest = 0;
  for (const signal::SampleRange& range : signal::stretches_of(values)) longest = std::max(longest, range.count());
  return longest;
}

std::vector<double> bridged_values(const SignalRecord& record) {
  std::vector<double> values = record.values;
  signal::fill_short_gaps(values, signal::PhaseRecord::kBridge);
  return values;
}

base::Result<std::vector<double>> denoised_values(const SignalRecord& record, const WmraRequest& request) {
  const auto split = wmra(record, request);
  if (!split) return base::forward_error(split);
  std::vector<double> values = record.values;
  std::size_t next = 0;
  for (double& value : values) {
    if (!std::isnan(value)) value = split->denoised[next++];
  }
  signal::fill_short_gaps(values, signal::PhaseRecord::kBridge);
  return values;
}

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

base::Status check_changes(std::span<const double> values) {
  bool compared = false;
  std::size_t last = values.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (last < i && i - last <= signal::PhaseRecord::kBridge + 1) {
      if (values[i] != values[last]) return {};
      compared = true;
    }
    last = i;
  }
  if (!compared) return {};
  return base::bad_input("the samples never change: a stuck sensor has no noise");
}

Outliers outliers(std::span<const double> values) {
  const std::vector<double> differences = absolute_differences(values);
  if (differences.empty()) return {};
  const double sigma = std::max(robust_sigma(differences), least_difference(values)) / std::sqrt(2.0);
  Outliers found;
  double squares = 0.0;
  for (const SampleRange& stretch : signal::stretches_of(values)) {
    if (stretch.count() < kNeighbours) continue;
    for (std::size_t i = stretch.first; i < stretch.last; ++i) {
      const double sigmas = std::abs(values[i] - local_median(values, stretch, i)) / sigma;
      if (!(sigmas > kOutlier)) continue;
      found.at.push_back(i);
      found.largest_sigma = std::max(found.largest_sigma, sigmas);
      squares += sigmas * sigmas;
    }
  }
  // n samples know the variance to sqrt(2/n) of itself; the outliers add squares/n.
  const auto present = std::count_if(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
  return squares > std::sqrt(2.0 * static_cast<double>(present)) ? found : Outliers{};
}

std::vector<double> without(std::vector<double> values, const Outliers& outliers) {
  if (outliers.at.empty()) return values;
  const std::vector<double> raw = values;
  auto next = outliers.at.begin();
  for (const SampleRange& stretch : signal::stretches_of(raw)) {
    for (; next != outliers.at.end() && *next < stretch.last; ++next) values[*next] = local_median(raw, stretch, *next);
  }
  return values;
}

std::optional<Step> step(std::span<const double> values) {
  const std::vector<SampleRange> stretches = signal::stretches_of(values);
  std::size_t longest = 0;
  for (const SampleRange& stretch : stretches) longest = std::max(longest, stretch.count());
  Contrast best;
  for (std::size_t block = longest / (16 * kBlocksPerWindow); block >= kLeastBlock; block /= 4) {
    const Contrast found = contrast(values, stretches, block);
    if (found.sigmas > best.sigmas) best = found;
  }
  // A slow drift across one step of the quantisation is no step of the sensor.
  if (best.sigmas <= kStep || std::abs(best.step.height) <= 1.5 * least_difference(values)) {
    return std::nullopt;
  }
  return best.step;
}

}  // namespace soak::calib::signal_json
