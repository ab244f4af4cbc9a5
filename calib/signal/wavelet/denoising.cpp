// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/denoising.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/signal/wavelet/detail/checks.h"

namespace soak::calib::signal {
namespace {

base::Status check_options(const DenoisingOptions& options) {
  if (options.relaxation.size() > options.levels) {
    return base::bad_input(fmt::format("{} relaxation factors for {} levels; give at most one per level",
                                       options.relaxation.size(), options.levels));
  }
  if (const auto sound = denoising::check_not_negative(options.relaxation, "relaxation factor"); !sound) return sound;
  if (!options.threshold || (std::isfinite(*options.threshold) && *options.threshold >= 0.0)) return {};
  return base::bad_input(fmt::format("threshold is {}; it must be finite and at least 0", *options.threshold));
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
