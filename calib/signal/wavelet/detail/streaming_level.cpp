// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/streaming_level.h"

#include <algorithm>

namespace soak::calib::signal::denoising {
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

StreamingBanks::StreamingBanks(const Wavelet& wavelet)
    : transform(wavelet::banks_of(wavelet)), smoothing(without_details(transform.synthesis)) {}

std::span<const double> StreamingLevel::split(std::span<const double> samples, const StreamingBanks& banks,
                                              double threshold, Shrinkage shrinkage) {
  waiting_.append(samples);
  count_ += samples.size();
  if (!mirrored_) {
    if (count_ < banks.transform.length - 2) return {};
    mirror_start(banks.transform.length);
  }
  return split_waiting(banks, threshold, shrinkage);
}

std::span<const double> StreamingLevel::split_end(const StreamingBanks& banks, double threshold, Shrinkage shrinkage) {
  if (count_ == 0) return {};
  if (!mirrored_) mirror_start(banks.transform.length);
  mirror_end(banks.transform.length);
  return split_waiting(banks, threshold, shrinkage);
}

/// Puts x(-(F - 2)) to x(-1) before the samples.
void StreamingLevel::mirror_start(std::size_t length) {
  const auto before = static_cast<std::ptrdiff_t>(length - 2);
  std::vector<double> extended;
  for (std::ptrdiff_t i = -before; i < 0; ++i) extended.push_back(waiting_[mirrored_index(i, count_)]);
  extended.insert(extended.end(), waiting_.data(), waiting_.data() + waiting_.size());
  waiting_.clear();
  waiting_.append(extended);
  mirrored_ = true;
}

/// Puts x(n), x(n + 1).. after the samples: F - 2 of them, one more if n is odd. What waits reaches back as far.
void StreamingLevel::mirror_end(std::size_t length) {
  const std::size_t after = length - 2 + count_ % 2;
  std::vector<double> beyond;
  for (std::size_t i = 0; i < after; ++i) beyond.push_back(waiting_[waiting_.size() - 1 - i]);
  waiting_.append(beyond);
}

std::span<const double> StreamingLevel::split_waiting(const StreamingBanks& banks, double threshold,
                                                      Shrinkage shrinkage) {
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

StreamingLevel::Rebuilt StreamingLevel::rebuild(const Rebuilt& approximations, const StreamingBanks& banks) {
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

void StreamingLevel::combine(std::size_t pairs, const wavelet::Polyphase& bank, const SampleQueue& approximations,
                             std::vector<double>& samples) {
  even_.resize(pairs);
  odd_.resize(pairs);
  samples.resize(2 * pairs);
  wavelet::filter_bank(pairs, bank, approximations.data(), details_.data(), even_.data(), odd_.data());
  wavelet::interleave(pairs, even_.data(), odd_.data(), samples.data());
}

void StreamingLevel::clear() {
  mirrored_ = false;
  count_ = 0;
  for (SampleQueue* queue : {&waiting_, &details_, &signal_, &trend_}) queue->clear();
}

}  // namespace soak::calib::signal::denoising
