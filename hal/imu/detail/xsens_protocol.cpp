// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xsens_protocol.h"

#include <fmt/format.h>

namespace soak::hal::imu {

using namespace std::chrono_literals;

void XsensProtocol::append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point /*now*/,
                           bool /*drained*/) {
  decoder_.append(bytes);
}

base::Result<std::optional<Protocol::Heard>> XsensProtocol::next() {
  const auto message = decoder_.next();
  if (!message) return std::nullopt;
  const auto heard = take(*message);
  if (!heard) return base::forward_error(heard);
  return *heard;
}

base::Result<Protocol::Heard> XsensProtocol::take(const XbusMessage& message) {
  switch (message.id) {
    case Mid::mt_data2:
      return done() ? take_packet(message) : Heard::other;
    case Mid::wake_up:
      return Heard::wake_up;
    case Mid::error:
      return base::fail(base::ErrorKind::device,
                        fmt::format("the unit reports error {}{}",
                                    message.data.empty() ? "without a code" : fmt::format("code {}", message.data[0]),
                                    done() ? "" : fmt::format(" upon {}", setup_.request_name())));
    default:
      break;
  }
  if (listening_only_) return Heard::other;
  const auto moved_on = setup_.take(message);
  if (!moved_on) return base::forward_error(moved_on);
  return *moved_on ? Heard::answer : Heard::other;
}

Protocol::Heard XsensProtocol::take_packet(const XbusMessage& message) {
  const auto data = decode_mt_data2(message.data);
  if (!data) {
    malformed_bytes_ += message.frame_size;
    return Heard::other;
  }
  packet_ = {};
  packet_.stamped = data->packet_counter && data->sample_time_fine;
  if (packet_.stamped) stamp_ = {*data->packet_counter, *data->sample_time_fine};
  packet_.counter = stamp_.counter;
  packet_.temp_c = data->temp_c;
  packet_.measured = data->accel_mps2 && data->rate_rps;
  if (packet_.measured) {
    packet_.rate_rps = *data->rate_rps;
    packet_.accel_mps2 = *data->accel_mps2;
  }
  packet_.status = data->status.value_or(0);
  packet_.clipped = says_clipped(packet_.status);
  return Heard::packet;
}

void XsensProtocol::begin(const Imu::Settings& settings) {
  listening_only_ = false;
  rate_hz_ = settings.rate_hz;
  setup_ = XsensSetup(settings);
}

void XsensProtocol::assume_done(const Imu::Settings& settings) {
  begin(settings);
  listening_only_ = true;
}

/// A unit whose wake-up message got lost waits in configuration for ever. Long enough not to disturb one that pauses.
std::chrono::steady_clock::duration XsensProtocol::patience() const { return 30s; }

}  // namespace soak::hal::imu
