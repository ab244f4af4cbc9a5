// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/denoising.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "base/instruction_set.h"
#include "calib/signal/wavelet/detail/levels.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kLanes = 8;

// Rules without a branch: noise would make every one of them a coin toss. T >= 0.

struct Soft {
  /// d - clamp(d, -T, T)
  SOAK_INLINE static double kept(double d, double threshold) {
    const double below = d < threshold ? d : threshold;
    return d - (below > -threshold ? below : -threshold);
  }
};

struct Hard {
  SOAK_INLINE static double kept(double d, double threshold) { return std::abs(d) > threshold ? d : 0.0; }
};

struct Garrote {
  /// d - T^2/d as d (1 - q^2) with q = T/max(|d|, T)
  SOAK_INLINE static double kept(double d, double threshold) {
    const double size = std::abs(d) > threshold ? std::abs(d) : threshold;
    const double q = threshold / (size > kLeast ? size : kLeast);
    return d - d * q * q;
  }
  static constexpr double kLeast = std::numeric_limits<double>::min();  // 0/0 has no value
};

template <class Rule>
SOAK_INLINE void shrink_all(std::size_t count, double* d, double threshold) {
  const std::size_t whole = count - count % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) d[i + k] = Rule::kept(d[i + k], threshold);
  }
  for (std::size_t i = whole; i < count; ++i) d[i] = Rule::kept(d[i], threshold);
}

SOAK_CLONES void shrink_soft(std::size_t count, double* d, double threshold) { shrink_all<Soft>(count, d, threshold); }

SOAK_CLONES void shrink_hard(std::size_t count, double* d, double threshold) { shrink_all<Hard>(count, d, threshold); }

SOAK_CLONES void shrink_garrote(std::size_t count, double* d, double threshold) {
  shrink_all<Garrote>(count, d, threshold);
}

constexpr std::size_t kStride = 256;         // one value in so many belongs to the sample
constexpr std::size_t kWorthwhile = 16'384;  // below, all values are partitioned at once

/// Mean of the values of rank (n - 1)/2 and n/2 among n, of which `values` holds those from rank `below` on.
double middle(std::vector<double>& values, std::size_t below, std::size_t n) {
  const auto upper = values.begin() + static_cast<std::ptrdiff_t>(n / 2 - below);
  std::nth_element(values.begin(), upper, values.end());
  const double lower = n % 2 == 1 ? *upper : *std::max_element(values.begin(), upper);
  return 0.5 * lower + 0.5 * *upper;
}

std::vector<double> sizes(std::span<const double> values, std::size_t stride) {
  std::vector<double> size;
  size.reserve(values.size() / stride + 1);
  for (std::size_t i = 0; i < values.size(); i += stride) size.push_back(std::abs(values[i]));
  return size;
}

/// Two sizes that most likely have the median between them: in a sample of m its rank scatters by sqrt(m)/2, the
/// bracket reaches four times as far.
std::pair<double, double> bracket(std::span<const double> values) {
  std::vector<double> sample = sizes(values, kStride);
  std::sort(sample.begin(), sample.end());
  const auto reach = static_cast<std::size_t>(2.0 * std::sqrt(static_cast<double>(sample.size())));
  const std::size_t centre = sample.size() / 2;
  return {sample[centre - reach], sample[centre + reach]};
}

/// The sizes from `low` to `high`, and how many are below.
struct Between {
  std::vector<double> inside;
  std::size_t below = 0;
};

/// Adds those of a block of at most kStride values; no branch depends on them.
void add_block(std::span<const double> values, double low, double high, Between& found) {
  std::array<double, kStride> inside;
  std::size_t count = 0;
  for (const double v : values) {
    const double size = std::abs(v);
    inside[count] = size;
    found.below += static_cast<std::size_t>(size < low);
    count += static_cast<std::size_t>(size >= low) & static_cast<std::size_t>(size <= high);
  }
  found.inside.insert(found.inside.end(), inside.begin(), inside.begin() + static_cast<std::ptrdiff_t>(count));
}

Between between(std::span<const double> values, double low, double high) {
  Between found;
  for (std::size_t i = 0; i < values.size(); i += kStride) {
    add_block(values.subspan(i, std::min(kStride, values.size() - i)), low, high, found);
  }
  return found;
}

/// Median of |v| (mean of the two middle ones for an even count), 0 for no values. Exact; O(n): a sample of the values
/// brackets the median, one pass without branches picks out the few between, and only these are partitioned.
double median_size(std::span<const double> values) {
  const std::size_t n = values.size();
  if (n == 0) return 0.0;
  if (n >= kWorthwhile) {
    const auto [low, high] = bracket(values);
    Between found = between(values, low, high);
    const bool holds_both = found.below <= (n - 1) / 2 && n / 2 < found.below + found.inside.size();
    if (holds_both) return middle(found.inside, found.below, n);
  }
  std::vector<double> all = sizes(values, 1);
  return middle(all, 0, n);
}

base::Status check_options(const DenoisingOptions& options) {
  if (options.relaxation.size() > options.levels) {
    return base::bad_input(fmt::format("{} relaxation factors for {} levels; give at most one per level",
                                       options.relaxation.size(), options.levels),
                           "relaxation");
  }
  if (const auto sound = wavelet::check_not_negative(options.relaxation, "relaxation factor"); !sound) return sound;
  if (!options.threshold || (std::isfinite(*options.threshold) && *options.threshold >= 0.0)) return {};
  return base::bad_input(fmt::format("threshold is {}; it must be finite and at least 0", *options.threshold),
                         "threshold");
}

/// Threshold of level j = 1, 2.. before its relaxation factor.
double threshold_of(std::size_t j, std::size_t samples, const std::vector<double>& sigma,
                    const DenoisingOptions& options) {
  const auto n = static_cast<double>(samples);
  if (options.threshold) return *options.threshold;
  if (options.noise == NoiseFrom::finest) return universal_threshold(sigma.front(), n);
  // T_j = sigma_j sqrt(2 ln(N/2^j))
  return universal_threshold(sigma[j - 1], std::ldexp(n, -static_cast<int>(j)));
}

std::vector<double> noise_levels(const Decomposition& parts) {
  std::vector<double> sigma;
  for (const auto& details : parts.details) sigma.push_back(noise_level(details));
  return sigma;
}

std::vector<double> thresholds(std::size_t samples, const std::vector<double>& sigma, const DenoisingOptions& options) {
  std::vector<double> thresholds;
  for (std::size_t j = 1; j <= sigma.size(); ++j) {
    const double factor = j <= options.relaxation.size() ? options.relaxation[j - 1] : 1.0;
    thresholds.push_back(factor * threshold_of(j, samples, sigma, options));
  }
  return thresholds;
}

base::Status rebuild(Decomposition& parts, const Wavelet& wavelet, Shrinkage shrinkage, Denoised& into) {
  for (std::size_t j = 0; j < parts.levels(); ++j) shrink(parts.details[j], into.thresholds[j], shrinkage);
  std::vector<double> scratch = std::move(parts.workspace);
  into.signal.resize(parts.samples);
  if (auto built = reconstruct(parts, wavelet, scratch, into.signal); !built) return built;
  for (auto& details : parts.details) std::fill(details.begin(), details.end(), 0.0);
  into.trend.resize(parts.samples);
  return reconstruct(parts, wavelet, scratch, into.trend);
}

}  // namespace

void shrink(std::span<double> coefficients, double threshold, Shrinkage shrinkage) {
  switch (shrinkage) {
    case Shrinkage::none:
      return;
    case Shrinkage::soft:
      return shrink_soft(coefficients.size(), coefficients.data(), threshold);
    case Shrinkage::hard:
      return shrink_hard(coefficients.size(), coefficients.data(), threshold);
    case Shrinkage::garrote:
      return shrink_garrote(coefficients.size(), coefficients.data(), threshold);
  }
}

double noise_level(std::span<const double> details) {
  constexpr double kMedianOfNormal = 0.6745;  // median of |x| for a standard normal x, as printed
  return median_size(details) / kMedianOfNormal;
}

double universal_threshold(double sigma, double n) { return n > 1.0 ? sigma * std::sqrt(2.0 * std::log(n)) : 0.0; }

base::Result<Denoised> denoise(std::span<const double> samples, const Wavelet& wavelet,
                               const DenoisingOptions& options) {
  if (const auto sound = check_options(options); !sound) return base::forward_error(sound);
  Decomposition parts;
  const auto split = decompose(samples, wavelet, options.levels, options.boundary, parts);
  if (!split) return base::forward_error(split);
  Denoised result;
  result.sigma = noise_levels(parts);
  result.thresholds = thresholds(samples.size(), result.sigma, options);
  const auto built = rebuild(parts, wavelet, options.shrinkage, result);
  if (!built) return base::forward_error(built);
  return result;
}

}  // namespace soak::calib::signal
