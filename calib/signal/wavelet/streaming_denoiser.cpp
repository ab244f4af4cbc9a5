// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/streaming_denoiser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "calib/signal/wavelet/detail/kernels.h"
#include "calib/signal/wavelet/detail/levels.h"

namespace soak::calib::signal {
namespace denoising {
namespace {

/// Index of x(i) for any i in a signal of n samples mirrored at the half sample at both ends, again and again.
std::size_t mirrored_index(std::ptrdiff_t i, std::size_t n) {
  const auto period = static_cast<std::ptrdiff_t>(2 * n);
  const auto place = static_cast<std::size_t>((i % period + period) % period);
  return place < n ? place : 2 * n - 1 - place;
}

wavelet::Polyphase without_details(wavelet::Polyphase bank) {
  for (std::size_t t = 0; t < bank.taps; ++t) {
    bank.tap[t].first_by_second = 0.0;
    bank.tap[t].second_by_second = 0.0;
  }
  return bank;
}

}  // namespace

/// Numbers that wait, oldest first, side by side in memory. Keeps room for at most twice as many as ever waited.
class SampleQueue {
 public:
  [[nodiscard]] std::size_t size() const { return values_.size() - first_; }
  [[nodiscard]] const double* data() const { return values_.data() + first_; }
  [[nodiscard]] double operator[](std::size_t i) const { return values_[first_ + i]; }

  void append(std::span<const double> values) {
    close_up();
    values_.insert(values_.end(), values.begin(), values.end());
  }

  /// The oldest `count` have been dealt with.
  void drop(std::size_t count) { first_ += count; }

  void clear() {
    values_.clear();
    first_ = 0;
  }

 private:
  /// Moves what waits to the front, not before as many are gone: a constant time per number.
  void close_up() {
    if (first_ < size()) return;
    values_.erase(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }

  std::vector<double> values_;
  std::size_t first_ = 0;
};

/// A wavelet's filters as the kernels take them.
struct StreamingBanks {
  /// Precondition: that of banks_of().
  explicit StreamingBanks(const Wavelet& wavelet)
      : transform(wavelet::banks_of(wavelet)), smoothing(without_details(transform.synthesis)) {}

  wavelet::Banks transform;
  wavelet::Polyphase smoothing;  ///< transform.synthesis with all details taken as 0
};

/// One level of a running transform and its inverse: splits the approximations of the finer level (the signal itself at
/// the finest) into its own approximations and details, keeps the details until the coarser level has rebuilt these
/// approximations, and rebuilds those of the finer level from both.
///
/// With the signal x mirrored at its start, e[i] = x(i - (F - 2)), coefficient k is the sum of
/// rec(i) e[2k + i], i < F: the numbering of decompose(). The mirrored part is known after F - 2 samples.
///
/// What the functions return stands in the level's own memory: valid until its next call.
class StreamingLevel {
 public:
  /// The next samples of the level's signal; the approximations that follow from them.
  [[nodiscard]] std::span<const double> split(std::span<const double> samples, const StreamingBanks& banks,
                                              double threshold, Shrinkage shrinkage) {
    waiting_.append(samples);
    count_ += samples.size();
    if (!mirrored_) {
      if (count_ < banks.transform.length - 2) return {};
      mirror_start(banks.transform.length);
    }
    return split_waiting(banks, threshold, shrinkage);
  }

  /// The signal ends: the approximations that need what lies beyond, mirrored.
  [[nodiscard]] std::span<const double> split_end(const StreamingBanks& banks, double threshold, Shrinkage shrinkage) {
    if (count_ == 0) return {};
    if (!mirrored_) mirror_start(banks.transform.length);
    mirror_end(banks.transform.length);
    return split_waiting(banks, threshold, shrinkage);
  }

  /// Rebuilt approximations of this level, from the denoised details and from none.
  struct Rebuilt {
    std::span<const double> signal;
    std::span<const double> trend;
  };
  /// The next approximations; the samples of the level's signal that follow from them. An odd signal comes out with one
  /// sample too many at its end.
  [[nodiscard]] Rebuilt rebuild(const Rebuilt& approximations, const StreamingBanks& banks) {
    signal_.append(approximations.signal);
    trend_.append(approximations.trend);
    const std::size_t known = std::min(signal_.size(), details_.size());
    if (known < banks.transform.synthesis.taps) return {};
    const std::size_t pairs = known - banks.transform.synthesis.taps + 1;
    combine(pairs, banks.transform.synthesis, signal_, signal_out_);
    combine(pairs, banks.smoothing, trend_, trend_out_);
    signal_.drop(pairs);
    trend_.drop(pairs);
    details_.drop(pairs);
    return {signal_out_, trend_out_};
  }

  /// As new.
  void clear() {
    mirrored_ = false;
    count_ = 0;
    for (SampleQueue* queue : {&waiting_, &details_, &signal_, &trend_}) queue->clear();
  }

 private:
  /// Puts x(-(F - 2)) to x(-1) before the samples.
  void mirror_start(std::size_t length) {
    const auto before = static_cast<std::ptrdiff_t>(length - 2);
    std::vector<double> extended;
    for (std::ptrdiff_t i = -before; i < 0; ++i) extended.push_back(waiting_[mirrored_index(i, count_)]);
    extended.insert(extended.end(), waiting_.data(), waiting_.data() + waiting_.size());
    waiting_.clear();
    waiting_.append(extended);
    mirrored_ = true;
  }

  /// Puts x(n), x(n + 1).. after the samples: F - 2 of them, one more if n is odd. What waits reaches back as far.
  void mirror_end(std::size_t length) {
    const std::size_t after = length - 2 + count_ % 2;
    std::vector<double> beyond;
    for (std::size_t i = 0; i < after; ++i) beyond.push_back(waiting_[waiting_.size() - 1 - i]);
    waiting_.append(beyond);
  }

  std::span<const double> split_waiting(const StreamingBanks& banks, double threshold, Shrinkage shrinkage) {
    const std::size_t pairs = waiting_.size() / 2;
    if (pairs < banks.transform.analysis.taps) return {};
    const std::size_t count = pairs - banks.transform.analysis.taps + 1;
    even_.resize(pairs);
    odd_.resize(pairs);
    approximation_.resize(count);
    detail_.resize(count);
    wavelet::deinterleave(pairs, waiting_.data(), even_.data(), odd_.data());
    wavelet::filter_bank(count, banks.transform.analysis, even_.data(), odd_.data(), approximation_.data(),
                         detail_.data());
    waiting_.drop(2 * count);
    shrink(detail_, threshold, shrinkage);
    details_.append(detail_);
    return approximation_;
  }

  void combine(std::size_t pairs, const wavelet::Polyphase& bank, const SampleQueue& approximations,
               std::vector<double>& samples) {
    even_.resize(pairs);
    odd_.resize(pairs);
    samples.resize(2 * pairs);
    wavelet::filter_bank(pairs, bank, approximations.data(), details_.data(), even_.data(), odd_.data());
    wavelet::interleave(pairs, even_.data(), odd_.data(), samples.data());
  }

  bool mirrored_ = false;  ///< `waiting_` begins with the mirrored start
  std::size_t count_ = 0;  ///< samples of the level's signal so far
  SampleQueue waiting_;    ///< samples and what the next coefficients need of those before
  SampleQueue details_;    ///< shrunk, from the next pair of samples to rebuild on
  SampleQueue signal_;     ///< rebuilt approximations, from the same place on
  SampleQueue trend_;
  std::vector<double> even_;  ///< working memory of the calls, like the following
  std::vector<double> odd_;
  std::vector<double> approximation_;
  std::vector<double> detail_;
  std::vector<double> signal_out_;
  std::vector<double> trend_out_;
};

}  // namespace denoising

namespace {

using denoising::StreamingBanks;
using denoising::StreamingLevel;

/// Samples that pass through all levels at a time: enough for the kernels, few enough to bound the memory.
constexpr std::size_t kSlice = 1024;

base::Status check_threshold_count(std::size_t levels) {
  if (levels >= 1 && levels <= StreamingDenoiser::kMaxLevels) return {};
  return base::bad_input(
      fmt::format("{} thresholds; give one per level, 1 to {}", levels, StreamingDenoiser::kMaxLevels), "thresholds");
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
  if (const auto sound = wavelet::check_filters(wavelet); !sound) return base::forward_error(sound);
  if (const auto sound = check_threshold_count(thresholds.size()); !sound) return base::forward_error(sound);
  const auto sound = wavelet::check_not_negative(thresholds, "threshold");
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
        fmt::format("{} thresholds for {} levels; give one per level", thresholds.size(), impl_->levels.size()),
        "thresholds");
  }
  if (const auto sound = wavelet::check_not_negative(thresholds, "threshold"); !sound) return sound;
  impl_->thresholds.assign(thresholds.begin(), thresholds.end());
  return {};
}

}  // namespace soak::calib::signal
