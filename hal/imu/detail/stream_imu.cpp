// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/stream_imu.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "hal/imu/detail/ahrs400_protocol.h"
#include "hal/imu/detail/vectornav_protocol.h"
#include "hal/imu/detail/xsens_protocol.h"

namespace soak::hal::imu {
namespace {

constexpr auto kAnswerTimeout = std::chrono::seconds(1);
constexpr int kRepetitions = 3;
/// A frame whose rest has not come by then does not come at all: its beginning was garbage.
constexpr auto kFrameTimeout = std::chrono::milliseconds(500);
constexpr auto kSilentAfter = std::chrono::seconds(3);
constexpr std::size_t kMostUnsentBytes = 1024;

}  // namespace

StreamImu::StreamImu(std::unique_ptr<ByteSource> source, std::unique_ptr<Protocol> protocol,
                     std::function<Clock::time_point()> clock)
    : source_(std::move(source)), protocol_(std::move(protocol)), clock_(std::move(clock)) {}

base::Status StreamImu::open(const Settings& settings) {
  close();
  if (const base::Status checked = protocol_->check(settings); !checked) return checked;
  if (const base::Status opened = source_->open(); !opened) return opened;
  settings_ = settings;
  state_ = ImuState::silent;
  now_ = last_bytes_ = last_message_ = clock_();
  attempts_ = 0;
  if (source_->answers()) {
    begin_setup();
  } else {
    protocol_->assume_done(settings_);
    finish_setup();
  }
  return {};
}

void StreamImu::close() {
  source_->close();
  protocol_->clear();
  outbox_.clear();
  state_ = ImuState::closed;
}

base::Status StreamImu::poll(std::vector<ImuSample>& samples) {
  if (state_ == ImuState::closed) return base::fail(base::ErrorKind::device, "the unit is not open", description());
  if (state_ == ImuState::failed) return tl::unexpected(failure_);
  now_ = clock_();
  base::Status status = move_on(samples);
  statistics_.garbage_bytes = protocol_->garbage_bytes();
  if (!status) {
    if (status.error().where.empty()) status.error().where = description();
    close();
    state_ = ImuState::failed;
    failure_ = status.error();
  }
  return status;
}

base::Status StreamImu::move_on(std::vector<ImuSample>& samples) {
  const auto more_waits = receive(samples);
  if (!more_waits) return base::forward_error(more_waits);
  // What is still unread may be the answer: no time is up before all was read.
  if (!*more_waits) {
    if (const base::Status watched = watch_time(samples); !watched) return watched;
  }
  return send();
}

/// Reads and decodes what has arrived. Returns whether it stopped before all was read.
base::Result<bool> StreamImu::receive(std::vector<ImuSample>& samples) {
  std::array<std::uint8_t, 16384> chunk;
  for (std::size_t total = 0; total < kBytesPerPoll;) {
    const auto room = std::min(chunk.size(), kBytesPerPoll - total);
    const auto count = source_->read(std::span(chunk).first(room));
    if (!count) return base::forward_error(count);
    if (*count == 0) return false;
    total += *count;
    heard_ = true;
    last_bytes_ = now_;
    if (!protocol_->done()) state_ = ImuState::configuring;
    protocol_->append(std::span(chunk).first(*count), now_, *count < room);
    if (const base::Status taken = take_messages(samples); !taken) return base::forward_error(taken);
  }
  return true;
}

base::Status StreamImu::send() {
  if (outbox_.empty()) return {};
  const auto sent = source_->write(outbox_);
  if (!sent) return base::forward_error(sent);
  outbox_.erase(outbox_.begin(), outbox_.begin() + static_cast<std::ptrdiff_t>(*sent));
  return {};
}

void StreamImu::queue(const base::Bytes& message) {
  if (outbox_.size() > kMostUnsentBytes) outbox_.clear();
  outbox_.insert(outbox_.end(), message.begin(), message.end());
}

base::Status StreamImu::take_messages(std::vector<ImuSample>& samples) {
  for (;;) {
    const auto message = protocol_->next();
    if (!message) return base::forward_error(message);
    if (!*message) return {};
    if (now_ - last_message_ >= kSilentAfter) last_sample_ = now_;
    last_message_ = now_;
    take_message(**message, samples);
    unit_known_ = true;
  }
}

void StreamImu::take_message(Protocol::Heard message, std::vector<ImuSample>& samples) {
  switch (message) {
    case Protocol::Heard::packet:
      return take_packet(samples);
    case Protocol::Heard::wake_up:
      return take_wake_up();
    case Protocol::Heard::answer:
      return move_dialogue_on();
    case Protocol::Heard::other:
      return;
  }
}

void StreamImu::move_dialogue_on() {
  if (protocol_->done()) {
    finish_setup();
  } else {
    ask();
  }
}

void StreamImu::take_wake_up() {
  if (unit_known_) notice_restart();
  queue(protocol_->wake_up_answer());
  attempts_ = 0;
  state_ = ImuState::configuring;
  begin_setup();
}

void StreamImu::take_packet(std::vector<ImuSample>& samples) {
  const UnitPacket& packet = protocol_->packet();
  if (packet.stamped && !follow()) return;
  // A packet that a gateway has sent again, or a clock that stands still: nothing new of any moment.
  if (packet.stamped && packet.measured && sample_s_ && protocol_->time_s() <= *sample_s_) return;
  take_temperature(packet);
  if (packet.stamped && packet.measured) append_sample(packet, samples);
}

/// Brings the unit's clock to a packet; false if the unit has restarted and its stream is no longer what was asked for.
bool StreamImu::follow() {
  const bool just_configured = std::exchange(first_packet_, false);
  bool follows = protocol_->advance();
  if (!follows) {
    notice_restart();
    if (just_configured || !source_->answers()) {
      // The restart lies before the configuration, or cannot be followed by another one: this packet is the first of
      // the new power-on.
      follows = protocol_->advance();
    } else {
      state_ = ImuState::configuring;
      begin_setup();
    }
  }
  if (follows) {
    statistics_.lost_packets += protocol_->lost_packets();
    pending_lost_ += protocol_->lost_packets();
  }
  return follows;
}

/// Keeps a reading for the next sample. Of a thermometer that comes with every packet only the share that was asked
/// for: the others tell nothing new of a body that takes minutes to warm.
void StreamImu::take_temperature(const UnitPacket& packet) {
  if (!packet.temp_c) return;
  if (protocol_->temp_with_every_packet()) {
    const double t_s = protocol_->time_s();
    const double period_s = 1.0 / settings_.temp_rate_hz;
    // Half a packet early is in time: stamps need not fall on the grid.
    if (t_s < next_temp_s_ - 0.5 / settings_.rate_hz) return;
    next_temp_s_ = (next_temp_s_ + period_s > t_s ? next_temp_s_ : t_s) + period_s;
  }
  pending_temp_c_ = packet.temp_c;
}

void StreamImu::append_sample(const UnitPacket& packet, std::vector<ImuSample>& samples) {
  ImuSample& sample = samples.emplace_back();
  sample.t_s = protocol_->time_s();
  sample_s_ = sample.t_s;
  sample.power_on = power_on_;
  sample.packet = packet.counter;
  sample.lost = std::exchange(pending_lost_, 0);
  sample.rate_rps = packet.rate_rps;
  sample.accel_mps2 = packet.accel_mps2;
  sample.temp_c = std::exchange(pending_temp_c_, std::nullopt);
  sample.status = packet.status;
  sample.clipped = packet.clipped;
  ++statistics_.packets;
  state_ = ImuState::streaming;
  last_sample_ = now_;
  sampled_ = true;
}

base::Status StreamImu::watch_time(std::vector<ImuSample>& samples) {
  const auto quiet = now_ - last_bytes_;
  if (const auto moved_on = protocol_->end_answer(quiet); !moved_on) {
    return base::forward_error(moved_on);
  } else if (*moved_on) {
    move_dialogue_on();
  }
  if (quiet >= kFrameTimeout) {
    while (protocol_->drop_partial()) {
      if (const base::Status taken = take_messages(samples); !taken) return taken;
    }
  }
  if (!source_->answers()) return {};
  return protocol_->done() ? watch_stream() : watch_setup();
}

base::Status StreamImu::watch_setup() {
  if (now_ < deadline_) return {};
  if (!heard_) {
    state_ = ImuState::silent;
    attempts_ = 0;
  } else if (++attempts_ > kRepetitions) {
    return base::fail(base::ErrorKind::device,
                      fmt::format("the unit sends bytes but does not answer {} (another baud rate or kind of unit?)",
                                  protocol_->request_name()));
  }
  begin_setup();
  return {};
}

base::Status StreamImu::watch_stream() {
  const auto quiet = now_ - last_message_;
  if (quiet >= kSilentAfter) {
    state_ = ImuState::silent;
    if (quiet >= protocol_->silence_limit()) begin_setup();
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

void StreamImu::begin_setup() {
  protocol_->begin(settings_);
  heard_ = false;
  ask();
}

void StreamImu::ask() {
  queue(protocol_->request());
  deadline_ = now_ + kAnswerTimeout;
}

void StreamImu::finish_setup() {
  attempts_ = 0;
  if (source_->answers()) {
    const bool another = identity_ && identity_->serial != protocol_->identity().serial;
    if ((another || protocol_->found_idle()) && !protocol_->clock_empty()) notice_restart();
    identity_ = protocol_->identity();
  }
  queue(protocol_->start_command());
  protocol_->interrupt();
  first_packet_ = true;
  last_message_ = now_;
  last_sample_ = now_;
  sampled_ = false;
  state_ = ImuState::streaming;
}

void StreamImu::notice_restart() {
  ++statistics_.restarts;
  ++power_on_;
  protocol_->restart_clock();
  pending_temp_c_.reset();
  pending_lost_ = 0;
  sample_s_.reset();
  next_temp_s_ = 0.0;
}

}  // namespace soak::hal::imu

namespace soak::hal {
namespace {

std::unique_ptr<imu::Protocol> make_protocol(const UnitLink& link) {
  switch (link.decoder) {
    case UnitDecoder::ahrs400:
      return std::make_unique<imu::Ahrs400Protocol>(link.ranges);
    case UnitDecoder::vectornav:
      return std::make_unique<imu::VectorNavProtocol>();
    case UnitDecoder::xsens:
      break;
  }
  return std::make_unique<imu::XsensProtocol>();
}

struct SourceOf {
  auto operator()(const TcpAddress& address) const { return imu::make_tcp_source(address); }
  auto operator()(const SerialAddress& address) const { return imu::make_serial_source(address); }
  auto operator()(const UsbAddress& address) const { return imu::make_usb_source(address); }
  auto operator()(const RecordedAddress& address) const { return imu::make_recorded_source(address); }
};

}  // namespace

std::unique_ptr<Imu> make_imu(const UnitLink& link) {
  return std::make_unique<imu::StreamImu>(imu::make_source(link.address), make_protocol(link));
}

}  // namespace soak::hal

namespace soak::hal::imu {

std::unique_ptr<ByteSource> make_source(const UnitAddress& address) { return std::visit(hal::SourceOf{}, address); }

}  // namespace soak::hal::imu
