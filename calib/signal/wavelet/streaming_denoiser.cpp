// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/streaming_denoiser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/signal/wavelet/detail/checks.h"
#include "calib/signal/wavelet/detail/streaming_level.h"

namespace soak::calib::signal {
namespace {

using denoising::StreamingBanks;
using denoising::StreamingLevel;

/// Samples that pass through all levels at a time: enough for the kernels, few enough to bound the memory.
constexpr std::size_t kSlice = 1024;

base::Status check_wavelet(const Wavelet& w) {
  const std::size_t length = w.length();
  const bool alike = w.dec_hi.size() == length && w.rec_lo.size() == length && w.rec_hi.size() == length;
  if (alike && length % 2 == 0 && length >= 2 && length <= wavelet::kMaxLength) return {};
  return base::bad_input(
      fmt::format("the filters must all have the same even length from 2 to {}", wavelet::kMaxLength),
      "wavelet " + w.name);
}

base::Status check_levels(std::size_t levels) {
  if (levels >= 1 && levels <= StreamingDenoiser::kMaxLevels) return {};
  return base::bad_input(
      fmt::format("{} thresholds; give one per level, 1 to {}", levels, StreamingDenoiser::kMaxLevels));
}

}  // namespace

struct StreamingDenoiser::Impl {
  StreamingBanks banks;
  Shrinkage shrinkage;
  std::vector<double> thresholds;
  std::vector<StreamingLevel> levels;
  std::size_t taken = 0;  ///< samples of this signal
  std::size_t given = 0;  ///< of these, the ones that have come out

  Impl(const Wavelet& wavelet, Shrinkage rule, std::span<const double> limits)
      : banks(wavelet), shrinkage(rule), thresholds(limits.begin(), limits.end()), levels(limits.size()) {}

  /// Samples through all levels, from the finest to the coarsest and back.
  void pass(std::span<const double> samples, StreamedSamples& into) {
    taken += samples.size();
    for (std::size_t j = 0; j < levels.size(); ++j) samples = levels[j].split(samples, banks, thresholds[j], shrinkage);
    rebuild(samples, into);
  }

  /// The end of the signal through all levels: what one level still had is the end of the next one's signal.
  void pass_end(StreamedSamples& into) {
    std::vector<double> rest;
    for (std::size_t j = 0; j < levels.size(); ++j) {
      const auto due = levels[j].split(rest, banks, thresholds[j], shrinkage);
      std::vector<double> next(due.begin(), due.end());
      const auto last = levels[j].split_end(banks, thresholds[j], shrinkage);
      next.insert(next.end(), last.begin(), last.end());
      rest = std::move(next);
    }
    rebuild(rest, into);
  }

  void rebuild(std::span<const double> coarsest, StreamedSamples& into) {
    StreamingLevel::Rebuilt rebuilt{coarsest, coarsest};
    for (std::size_t j = levels.size(); j-- > 0;) rebuilt = levels[j].rebuild(rebuilt, banks);
    const std::size_t count = std::min(rebuilt.signal.size(), taken - given);
    given += count;
    append(rebuilt.signal.first(count), into.signal);
    append(rebuilt.trend.first(count), into.trend);
  }

  static void append(std::span<const double> values, std::vector<double>& to) {
    to.insert(to.end(), values.begin(), values.end());
  }
};

StreamingDenoiser::StreamingDenoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StreamingDenoiser::StreamingDenoiser(StreamingDenoiser&&) noexcept = default;
StreamingDenoiser& StreamingDenoiser::operator=(StreamingDenoiser&&) noexcept = default;
StreamingDenoiser::~StreamingDenoiser() = default;

base::Result<StreamingDenoiser> StreamingDenoiser::create(const Wavelet& wavelet, Shrinkage shrinkage,
                                                          std::span<const double> thresholds) {
  if (const auto sound = check_wavelet(wavelet); !sound) return base::forward_error(sound);
  if (const auto sound = check_levels(thresholds.size()); !sound) return base::forward_error(sound);
  const auto sound = denoising::check_not_negative(thresholds, "threshold");
  if (!sound) return base::forward_error(sound);
  return StreamingDenoiser(std::make_unique<Impl>(wavelet, shrinkage, thresholds));
}

std::size_t StreamingDenoiser::latency() const {
  return ((std::size_t{1} << impl_->levels.size()) - 1) * (impl_->banks.transform.length - 1);
}

base::Status StreamingDenoiser::push(std::span<const double> samples, StreamedSamples& into) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isfinite(samples[i])) continue;
    return base::bad_input(
        fmt::format("the sample is {}; a missing sample ends the signal: flush, then go on after it", samples[i]),
        fmt::format("sample {}", impl_->taken + i));
  }
  for (std::size_t i = 0; i < samples.size(); i += kSlice) {
    impl_->pass(samples.subspan(i, std::min(kSlice, samples.size() - i)), into);
  }
  return {};
}

void StreamingDenoiser::flush(StreamedSamples& into) {
  impl_->pass_end(into);
  for (StreamingLevel& level : impl_->levels) level.clear();
  impl_->taken = 0;
  impl_->given = 0;
}

base::Status StreamingDenoiser::set_thresholds(std::span<const double> thresholds) {
  if (thresholds.size() != impl_->levels.size()) {
    return base::bad_input(
        fmt::format("{} thresholds for {} levels; give one per level", thresholds.size(), impl_->levels.size()));
  }
  if (const auto sound = denoising::check_not_negative(thresholds, "threshold"); !sound) return sound;
  impl_->thresholds.assign(thresholds.begin(), thresholds.end());
  return {};
}

}  // namespace soak::calib::signal
