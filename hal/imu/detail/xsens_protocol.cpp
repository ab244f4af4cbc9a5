// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xsens_protocol.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace soak::hal::imu {

// --- the unit's clock

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

void PacketTimeline::restart_clock() {
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

// --- the dialogue

namespace {

constexpr std::uint16_t kWithEveryPacket = 0xFFFF;
constexpr double kXsensRateTolerance = 0.01;
constexpr std::size_t kOutputSize = 4;

struct SetupStep {
  Mid request;
  std::string_view name;
};

constexpr std::array kSteps = {
    SetupStep{Mid::go_to_config, "the request to enter configuration (30)"},
    SetupStep{Mid::request_device_id, "the request for its device id (00)"},
    SetupStep{Mid::request_product_code, "the request for its product code (1C)"},
    SetupStep{Mid::request_firmware, "the request for its firmware revision (12)"},
    SetupStep{Mid::set_output_configuration, "the output configuration (C0)"},
    SetupStep{Mid::go_to_measurement, "the request to enter measurement (10)"},
};

/// One line of the output configuration.
struct Output {
  std::uint16_t id;
  std::string_view name;
  std::uint16_t rate_hz;
};

std::array<Output, 6> outputs_for(const Imu::Settings& settings) {
  const auto rate_hz = static_cast<std::uint16_t>(settings.rate_hz);
  const auto temp_rate_hz = static_cast<std::uint16_t>(settings.temp_rate_hz);
  return {{{data_id::kPacketCounter, "packet counter", kWithEveryPacket},
           {data_id::kSampleTimeFine, "sample time", kWithEveryPacket},
           {data_id::kAcceleration, "acceleration", rate_hz},
           {data_id::kRateOfTurn, "rate of turn", rate_hz},
           {data_id::kTemperature, "temperature", temp_rate_hz},
           {data_id::kStatusWord, "status word", kWithEveryPacket}}};
}

void append_big_endian(base::Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

base::Bytes compose(const std::array<Output, 6>& outputs) {
  base::Bytes bytes;
  for (const Output& output : outputs) {
    append_big_endian(bytes, output.id);
    append_big_endian(bytes, output.rate_hz);
  }
  return bytes;
}

tl::unexpected<base::Error> device_error(std::string message) {
  return base::fail(base::ErrorKind::device, std::move(message));
}

/// The rate that an output configuration gives `id`, whatever its number format.
std::optional<std::uint16_t> rate_of(std::uint16_t id, std::span<const std::uint8_t> configuration) {
  for (; !configuration.empty(); configuration = configuration.subspan(kOutputSize)) {
    if ((big_endian<std::uint16_t>(configuration.data()) & 0xFFF0U) == id) {
      return big_endian<std::uint16_t>(configuration.data() + 2);
    }
  }
  return std::nullopt;
}

bool is_near(std::uint16_t offered_hz, std::uint16_t asked_hz) {
  return std::abs(asked_hz - offered_hz) <= kXsensRateTolerance * asked_hz;
}

/// Printable characters without the padding.
std::string printable_text(std::span<const std::uint8_t> data) {
  std::string text;
  for (const std::uint8_t byte : data) {
    if (byte >= 0x20 && byte < 0x7F) text.push_back(static_cast<char>(byte));
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

bool is_rate(double rate_hz) { return rate_hz >= 1.0 && rate_hz <= 2000.0 && std::floor(rate_hz) == rate_hz; }

}  // namespace

base::Status check_rates(const Imu::Settings& settings) {
  for (const double rate_hz : {settings.rate_hz, settings.temp_rate_hz}) {
    if (is_rate(rate_hz)) continue;
    return base::bad_input(fmt::format("a rate must be a whole number of Hz from 1 to 2000, not {}", rate_hz));
  }
  return {};
}

void XsensSetup::begin() {
  step_ = 0;
  identity_ = {};
}

bool XsensSetup::done() const { return step_ == kSteps.size(); }

base::Bytes XsensSetup::request() const {
  const Mid id = kSteps[step_].request;
  return id == Mid::set_output_configuration ? encode_xbus(id, compose(outputs_for(settings_))) : encode_xbus(id);
}

std::string_view XsensSetup::request_name() const { return kSteps[step_].name; }

base::Result<bool> XsensSetup::take(const XbusMessage& message) {
  if (done() || message.id != answer_to(kSteps[step_].request)) return false;
  if (const base::Status taken = take_answer(kSteps[step_].request, message.data); !taken)
    return base::forward_error(taken);
  ++step_;
  return true;
}

base::Status XsensSetup::take_answer(Mid request, std::span<const std::uint8_t> data) {
  switch (request) {
    case Mid::request_device_id:
      if (data.size() != 4) return device_error(fmt::format("a device id of {} bytes: not 4", data.size()));
      identity_.serial = fmt::format("{:08X}", big_endian<std::uint32_t>(data.data()));
      return {};
    case Mid::request_product_code:
      identity_.product = printable_text(data);
      identity_.simulated = identity_.product.find("SIMULATED") != std::string::npos;
      return {};
    case Mid::request_firmware:
      if (data.size() < 3) return device_error(fmt::format("a firmware revision of {} bytes: not 3", data.size()));
      identity_.firmware = fmt::format("{}.{}.{}", data[0], data[1], data[2]);
      return {};
    case Mid::set_output_configuration:
      return check_offer(data);
    default:
      return {};
  }
}

base::Status XsensSetup::check_offer(std::span<const std::uint8_t> data) const {
  if (data.size() % kOutputSize != 0) return device_error("its answer to the output configuration is malformed");
  for (const Output& asked : outputs_for(settings_)) {
    const auto offered_hz = rate_of(asked.id, data);
    if (!offered_hz) return device_error(fmt::format("the unit does not offer {} ({:04X})", asked.name, asked.id));
    if (asked.rate_hz != kWithEveryPacket && !is_near(*offered_hz, asked.rate_hz)) {
      return device_error(fmt::format(
          "the unit offers {} ({:04X}) at {} Hz, not at the {} Hz requested: choose a rate that it supports",
          asked.name, asked.id, *offered_hz, asked.rate_hz));
    }
  }
  return {};
}

// --- the protocol

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
                                    done() ? "" : fmt::format(" in reply to {}", setup_.request_name())));
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
std::chrono::steady_clock::duration XsensProtocol::silence_limit() const { return std::chrono::seconds(30); }

}  // namespace soak::hal::imu
