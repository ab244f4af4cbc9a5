// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/packet_timeline.h"

#include "hal/imu/detail/mt_data2.h"

namespace soak::hal::imu {
namespace {

/// Longest gap in the stream across which a wrap of the time is taken for one: an hour. A longer gap there, once in 119
/// hours, looks like a restart.
constexpr std::uint32_t kLongestWrapGap = 3600U * 10'000U;

/// More packets than fit into `ticks`: twice the rate, because packets without a sample may come between.
double most_packets(std::uint32_t ticks, double rate_hz) { return 16.0 + 2.0 * rate_hz * ticks / kSampleTimeFine_hz; }

}  // namespace

bool PacketTimeline::advance(const PacketStamp& stamp) {
  std::uint32_t lost = 0;
  std::uint32_t ticks = stamp.time_fine;
  if (last_) {
    ticks = stamp.time_fine - last_->time_fine;
    if (stamp.time_fine < last_->time_fine && ticks > kLongestWrapGap) return false;
    const auto packets = static_cast<std::uint16_t>(stamp.counter - last_->counter);
    if (counter_known_ && packets > most_packets(ticks, rate_hz_)) return false;
    if (counter_known_ && packets > 1) lost = packets - 1U;
  }
  last_ = stamp;
  counter_known_ = true;
  ticks_ += ticks;
  lost_packets_ = lost;
  return true;
}

void PacketTimeline::begin_anew() {
  last_.reset();
  counter_known_ = false;
  ticks_ = 0;
  lost_packets_ = 0;
}

void PacketTimeline::interrupt(double rate_hz) {
  counter_known_ = false;
  rate_hz_ = rate_hz;
}

double PacketTimeline::time_s() const { return static_cast<double>(ticks_) / kSampleTimeFine_hz; }

}  // namespace soak::hal::imu
