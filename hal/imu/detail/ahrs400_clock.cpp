// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/ahrs400_clock.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::imu {
namespace {

/// Packets come every 14 ms or so: nothing for this long is a silence, and leaves no doubt below one wrap.
constexpr double kSilence_s = 0.045;
/// By how much the unit's clock may lag behind the host's without a gap: the step of 0.79 µs is rounded, and the unit's
/// crystal and the host's have tolerances of their own.
constexpr double kDrift = 0.02;

double seconds(std::chrono::steady_clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

std::vector<std::uint64_t> Ahrs400Clock::take(std::span<const Stamp> stamps, HostTime now, bool drained) {
  std::vector<std::uint64_t> steps;
  steps.reserve(stamps.size());
  if (stamps.empty()) return steps;
  const bool first = !timer_;
  std::uint64_t batch = 0;
  for (const Stamp& stamp : stamps) {
    steps.push_back(timer_ ? static_cast<std::uint16_t>(*timer_ - stamp.timer) : 0U);
    // The first step is no part of the batch: it lies before it.
    if (steps.size() > 1) batch += steps.back();
    ticks_ += steps.back();
    timer_ = stamp.timer;
  }
  if (!drained) {
    gap_open_ = gap_open_ || std::any_of(stamps.begin(), stamps.end(), [](const Stamp& s) { return s.after_loss; });
    return steps;
  }
  if (first || !began_) {
    began_ = heard_ = now;
    best_offset_s_ = -kTick_s * static_cast<double>(ticks_);
    gap_open_ = false;
    return steps;
  }
  const double silence_s = seconds(now - heard_);
  heard_ = now;
  double offset_s = seconds(now - *began_) - kTick_s * static_cast<double>(ticks_);
  const auto wraps = std::lround((offset_s - best_offset_s_) / kWrap_s);
  const auto place = place_of_gap(stamps, kTick_s * static_cast<double>(batch), silence_s);
  // A batch that was late and has no break may have been cut off at its end, by a buffer that was full.
  gap_open_ = wraps > 0 && !place;
  if (gap_open_) return steps;
  if (wraps > 0) {
    const std::uint64_t missing = static_cast<std::uint64_t>(wraps) << 16U;
    steps[*place] += missing;
    ticks_ += missing;
    offset_s -= kWrap_s * static_cast<double>(wraps);
  }
  follow_host(offset_s, silence_s);
  return steps;
}

std::optional<std::size_t> Ahrs400Clock::place_of_gap(std::span<const Stamp> stamps, double batch_s,
                                                      double silence_s) const {
  const auto loss = std::find_if(stamps.begin(), stamps.end(), [](const Stamp& stamp) { return stamp.after_loss; });
  if (loss != stamps.end()) return static_cast<std::size_t>(loss - stamps.begin());
  const bool paused = silence_s > kSilence_s && batch_s < kSilence_s;
  if (gap_open_ || paused) return 0;
  return std::nullopt;
}

void Ahrs400Clock::follow_host(double offset_s, double elapsed_s) {
  best_offset_s_ = std::min(offset_s, best_offset_s_ + kDrift * elapsed_s);
}

}  // namespace soak::hal::imu
