// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/xsens_imu.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace soak::hal::imu {
namespace {

using namespace std::chrono_literals;

constexpr auto kAnswerTimeout = 1s;
constexpr int kRepetitions = 3;
/// A frame whose rest has not come by then does not come at all: its beginning was garbage.
constexpr auto kFrameTimeout = 500ms;
constexpr auto kSilentAfter = 3s;
/// A unit whose wake-up message got lost waits in configuration for ever. Long enough not to disturb one that pauses.
constexpr auto kAskAgainAfter = 30s;
constexpr std::size_t kMostBytesPerPoll = 65536;
constexpr std::size_t kMostUnsentBytes = 1024;

}  // namespace

XsensImu::XsensImu(std::unique_ptr<ByteSource> source, std::function<Clock::time_point()> clock)
    : source_(std::move(source)), clock_(std::move(clock)), setup_(settings_) {}

base::Status XsensImu::open(const Settings& settings) {
  close();
  if (const base::Status checked = check_rates(settings); !checked) return checked;
  if (const base::Status opened = source_->open(); !opened) return opened;
  settings_ = settings;
  setup_ = XsensSetup(settings);
  state_ = ImuState::silent;
  now_ = last_bytes_ = last_message_ = clock_();
  attempts_ = 0;
  begin_setup();
  return {};
}

void XsensImu::close() {
  source_->close();
  decoder_.clear();
  outbox_.clear();
  state_ = ImuState::closed;
}

base::Status XsensImu::poll(std::vector<ImuSample>& samples) {
  if (state_ == ImuState::closed) return base::fail(base::ErrorKind::device, "the unit is not open", description());
  if (state_ == ImuState::failed) return tl::unexpected(failure_);
  now_ = clock_();
  base::Status status = move_on(samples);
  statistics_.garbage_bytes = decoder_.garbage_bytes() + malformed_bytes_;
  if (!status) {
    if (status.error().where.empty()) status.error().where = description();
    close();
    state_ = ImuState::failed;
    failure_ = status.error();
  }
  return status;
}

base::Status XsensImu::move_on(std::vector<ImuSample>& samples) {
  const auto more_waits = receive(samples);
  if (!more_waits) return base::forward_error(more_waits);
  // What is still unread may be the answer: no time is up before all was read.
  if (!*more_waits) {
    if (const base::Status watched = watch_time(samples); !watched) return watched;
  }
  return send();
}

/// Reads and decodes what has arrived. Returns whether it stopped before all was read.
base::Result<bool> XsensImu::receive(std::vector<ImuSample>& samples) {
  std::array<std::uint8_t, 16384> chunk;
  for (std::size_t total = 0; total < kMostBytesPerPoll;) {
    const auto room = std::min(chunk.size(), kMostBytesPerPoll - total);
    const auto count = source_->read(std::span(chunk).first(room));
    if (!count) return base::forward_error(count);
    if (*count == 0) return false;
    total += *count;
    heard_ = true;
    last_bytes_ = now_;
    if (!setup_.done()) state_ = ImuState::configuring;
    decoder_.append(std::span(chunk).first(*count));
    if (const base::Status taken = take_messages(samples); !taken) return base::forward_error(taken);
  }
  return true;
}

base::Status XsensImu::send() {
  if (outbox_.empty()) return {};
  const auto sent = source_->write(outbox_);
  if (!sent) return base::forward_error(sent);
  outbox_.erase(outbox_.begin(), outbox_.begin() + static_cast<std::ptrdiff_t>(*sent));
  return {};
}

void XsensImu::queue(const base::Bytes& message) {
  if (outbox_.size() > kMostUnsentBytes) outbox_.clear();
  outbox_.insert(outbox_.end(), message.begin(), message.end());
}

base::Status XsensImu::take_messages(std::vector<ImuSample>& samples) {
  while (const auto message = decoder_.next()) {
    if (now_ - last_message_ >= kSilentAfter) last_sample_ = now_;
    last_message_ = now_;
    if (const base::Status taken = take_message(*message, samples); !taken) return taken;
    unit_known_ = true;
  }
  return {};
}

base::Status XsensImu::take_message(const XbusMessage& message, std::vector<ImuSample>& samples) {
  switch (message.id) {
    case Mid::mt_data2:
      if (setup_.done()) take_packet(message, samples);
      return {};
    case Mid::wake_up:
      take_wake_up();
      return {};
    case Mid::error:
      return base::fail(base::ErrorKind::device,
                        fmt::format("the unit reports error {}{}",
                                    message.data.empty() ? "without a code" : fmt::format("code {}", message.data[0]),
                                    setup_.done() ? "" : fmt::format(" upon {}", setup_.request_name())));
    default:
      return take_answer(message);
  }
}

base::Status XsensImu::take_answer(const XbusMessage& message) {
  const auto moved_on = setup_.take(message);
  if (!moved_on) return base::forward_error(moved_on);
  if (!*moved_on) return {};
  if (setup_.done()) {
    finish_setup();
  } else {
    ask();
  }
  return {};
}

void XsensImu::take_wake_up() {
  if (unit_known_) notice_restart();
  queue(encode_xbus(Mid::wake_up_ack));
  attempts_ = 0;
  state_ = ImuState::configuring;
  begin_setup();
}

void XsensImu::take_packet(const XbusMessage& message, std::vector<ImuSample>& samples) {
  const auto packet = decode_mt_data2(message.data);
  if (!packet) {
    malformed_bytes_ += message.frame_size;
    return;
  }
  const bool stamped = packet->packet_counter && packet->sample_time_fine;
  if (stamped && !follow({*packet->packet_counter, *packet->sample_time_fine})) return;
  if (packet->temp_c) pending_temp_c_ = packet->temp_c;
  if (stamped && packet->accel_mps2 && packet->rate_rps) append_sample(*packet, samples);
}

/// Brings the timeline to a packet; false if the unit has restarted and its stream is no longer what was asked for.
bool XsensImu::follow(const PacketStamp& stamp) {
  const bool just_configured = std::exchange(first_packet_, false);
  bool follows = timeline_.advance(stamp);
  if (!follows) {
    notice_restart();
    if (just_configured) {
      // The restart lies before the configuration: this packet is the first of the new power-on.
      follows = timeline_.advance(stamp);
    } else {
      state_ = ImuState::configuring;
      begin_setup();
    }
  }
  if (follows) statistics_.lost_packets += timeline_.lost_packets();
  return follows;
}

void XsensImu::append_sample(const MtData2& packet, std::vector<ImuSample>& samples) {
  ImuSample& sample = samples.emplace_back();
  sample.t_s = timeline_.time_s();
  sample.power_on = power_on_;
  sample.packet = *packet.packet_counter;
  sample.rate_rps = *packet.rate_rps;
  sample.accel_mps2 = *packet.accel_mps2;
  sample.temp_c = std::exchange(pending_temp_c_, std::nullopt);
  sample.status = packet.status.value_or(0);
  sample.clipped = says_clipped(sample.status);
  ++statistics_.packets;
  state_ = ImuState::streaming;
  last_sample_ = now_;
  sampled_ = true;
}

base::Status XsensImu::watch_time(std::vector<ImuSample>& samples) {
  if (now_ - last_bytes_ >= kFrameTimeout) {
    while (decoder_.drop_partial()) {
      if (const base::Status taken = take_messages(samples); !taken) return taken;
    }
  }
  return setup_.done() ? watch_stream() : watch_setup();
}

base::Status XsensImu::watch_setup() {
  if (now_ < deadline_) return {};
  if (!heard_) {
    state_ = ImuState::silent;
    attempts_ = 0;
  } else if (++attempts_ > kRepetitions) {
    return base::fail(base::ErrorKind::device,
                      fmt::format("the unit sends bytes but does not answer {} (another baud rate or kind of unit?)",
                                  setup_.request_name()));
  }
  begin_setup();
  return {};
}

base::Status XsensImu::watch_stream() {
  const auto quiet = now_ - last_message_;
  if (quiet >= kSilentAfter) {
    state_ = ImuState::silent;
    if (quiet >= kAskAgainAfter) begin_setup();
  } else if (now_ - last_sample_ >= kSilentAfter) {
    if (!sampled_) {
      return base::fail(base::ErrorKind::device, "the unit sends packets, but not what it agreed to send");
    }
    // It obeys another configuration than ours: it has restarted and its wake-up message got lost.
    state_ = ImuState::configuring;
    begin_setup();
  }
  return {};
}

void XsensImu::begin_setup() {
  setup_.begin();
  heard_ = false;
  ask();
}

void XsensImu::ask() {
  queue(setup_.request());
  deadline_ = now_ + kAnswerTimeout;
}

void XsensImu::finish_setup() {
  attempts_ = 0;
  if (identity_ && identity_->serial != setup_.identity().serial && !timeline_.empty()) notice_restart();
  identity_ = setup_.identity();
  timeline_.interrupt(settings_.rate_hz);
  first_packet_ = true;
  last_sample_ = now_;
  sampled_ = false;
  state_ = ImuState::streaming;
}

void XsensImu::notice_restart() {
  ++statistics_.restarts;
  ++power_on_;
  timeline_.begin_anew();
  pending_temp_c_.reset();
}

}  // namespace soak::hal::imu

namespace soak::hal {

std::unique_ptr<Imu> make_xsens_imu(const std::variant<TcpAddress, SerialAddress>& address) {
  auto source = std::holds_alternative<TcpAddress>(address) ? imu::make_tcp_source(std::get<TcpAddress>(address))
                                                            : imu::make_serial_source(std::get<SerialAddress>(address));
  return std::make_unique<imu::XsensImu>(std::move(source));
}

}  // namespace soak::hal
