// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_device.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>

namespace soak::hal::sim {
namespace {

constexpr std::uint8_t kPreamble = 0xFA;
constexpr std::uint8_t kBusId = 0xFF;
constexpr std::uint8_t kExtended = 0xFF;
constexpr std::size_t kMaxShort = 254;
constexpr std::size_t kMaxData = 8192 - 7;

/// Sum modulo 256.
std::uint8_t xbus_sum_of(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return static_cast<std::uint8_t>(sum);
}

/// Where the data of a frame lie.
struct Extent {
  std::size_t start = 0;
  std::size_t length = 0;
};

/// Nothing while the header is incomplete.
std::optional<Extent> extent_of(std::span<const std::uint8_t> frame) {
  if (frame.size() < 4) return std::nullopt;
  if (frame[3] != kExtended) return Extent{4, frame[3]};
  if (frame.size() < 6) return std::nullopt;
  return Extent{6, static_cast<std::size_t>(frame[4]) << 8 | frame[5]};
}

constexpr std::uint16_t kEveryPacket = 0xFFFF;
constexpr std::size_t kBytesPerItem = 4;

bool comes_with_every_packet(std::uint16_t id) {
  return id == kPacketCounter || id == kSampleTimeFine || id == kStatusWord;
}

bool has_a_rate(std::uint16_t id) { return id == kTemperature || id == kAcceleration || id == kRateOfTurn; }

Tick divider_of(std::uint16_t rate_hz) {
  const double divider = std::round(static_cast<double>(kTicksPerSecond) / rate_hz);
  return std::max<Tick>(1, static_cast<Tick>(divider));
}

constexpr std::uint8_t kReqDeviceId = 0x00;
constexpr std::uint8_t kGotoMeasurement = 0x10;
constexpr std::uint8_t kReqFirmware = 0x12;
constexpr std::uint8_t kReqProductCode = 0x1C;
constexpr std::uint8_t kGotoConfig = 0x30;
constexpr std::uint8_t kMtData2 = 0x36;
constexpr std::uint8_t kXbusWakeUp = 0x3E;
constexpr std::uint8_t kWakeUpAck = 0x3F;
constexpr std::uint8_t kXbusReset = 0x40;
constexpr std::uint8_t kXbusError = 0x42;
constexpr std::uint8_t kOutputConfiguration = 0xC0;

constexpr std::uint8_t kInvalidMessage = 0x04;
constexpr std::uint8_t kInvalidParameter = 0x21;

constexpr std::string_view kProductCode = "MTi-300-SIMULATED   ";
constexpr std::uint8_t kXbusFirmware[] = {1, 8, 2};
constexpr Tick kFineTimePerTick = 10000 / kTicksPerSecond;

// Status word.
constexpr std::uint32_t kSelfTestOk = 1U << 0;
constexpr std::uint32_t kFilterValid = 1U << 1;
constexpr unsigned kClipAcceleration = 8;
constexpr unsigned kClipRate = 11;
constexpr std::uint32_t kClipAny = 1U << 19;

std::uint8_t acknowledged(std::uint8_t id) { return static_cast<std::uint8_t>(id + 1); }

std::uint32_t clip_bits(const SensedVector& sensed, unsigned first_bit) {
  std::uint32_t bits = 0;
  for (unsigned axis = 0; axis < 3; ++axis) {
    if (sensed.clipped[axis]) bits |= kClipAny | 1U << (first_bit + axis);
  }
  return bits;
}

void append_item_header(base::Bytes& data, std::uint16_t id, std::uint8_t size) {
  base::append_big_endian(data, id);
  data.push_back(size);
}

}  // namespace

// ---- Frames

base::Bytes xbus_frame(std::uint8_t id, std::span<const std::uint8_t> data) {
  base::Bytes frame = {kPreamble, kBusId, id};
  if (data.size() > kMaxShort) {
    frame.push_back(kExtended);
    base::append_big_endian(frame, static_cast<std::uint16_t>(data.size()));
  } else {
    frame.push_back(static_cast<std::uint8_t>(data.size()));
  }
  frame.insert(frame.end(), data.begin(), data.end());
  frame.push_back(static_cast<std::uint8_t>(-xbus_sum_of(std::span(frame).subspan(1))));
  return frame;
}

std::optional<XbusMessage> XbusParser::next() {
  while (true) {
    pending_.erase(pending_.begin(), std::find(pending_.begin(), pending_.end(), kPreamble));
    const auto extent = extent_of(pending_);
    if (!extent) return std::nullopt;
    const std::size_t end = extent->start + extent->length + 1;
    if (extent->length <= kMaxData && pending_.size() < end) return std::nullopt;
    const bool intact = extent->length <= kMaxData && xbus_sum_of(std::span(pending_).subspan(1, end - 1)) == 0;
    if (!intact) {
      pending_.erase(pending_.begin());
      continue;
    }
    XbusMessage message;
    message.id = pending_[2];
    const auto data = std::span(pending_).subspan(extent->start, extent->length);
    message.data.assign(data.begin(), data.end());
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(end));
    return message;
  }
}

// ---- Output configuration

OutputPlan OutputPlan::factory() {
  OutputPlan plan;
  plan.items_ = {{kPacketCounter, 0}, {kSampleTimeFine, 0}, {kAcceleration, 4}, {kRateOfTurn, 4}, {kTemperature, 40}};
  return plan;
}

std::optional<OutputPlan> OutputPlan::parse(std::span<const std::uint8_t> data) {
  if (data.size() % kBytesPerItem != 0) return std::nullopt;
  OutputPlan plan;
  for (std::size_t i = 0; i < data.size(); i += kBytesPerItem) {
    const std::uint16_t id = base::big_endian_u16(data, i);
    const std::uint16_t rate_hz = base::big_endian_u16(data, i + 2);
    if (comes_with_every_packet(id)) {
      plan.items_.push_back({id, 0});
    } else if (has_a_rate(id) && rate_hz > 0) {
      plan.items_.push_back({id, divider_of(rate_hz)});
    } else {
      return std::nullopt;
    }
  }
  return plan;
}

base::Bytes OutputPlan::data() const {
  base::Bytes data;
  for (const OutputItem& item : items_) {
    base::append_big_endian(data, item.id);
    base::append_big_endian(
        data, item.divider > 0 ? static_cast<std::uint16_t>(kTicksPerSecond / item.divider) : kEveryPacket);
  }
  return data;
}

std::optional<Tick> OutputPlan::next_packet(Tick tick) const {
  std::optional<Tick> next;
  for (const OutputItem& item : items_) {
    if (item.divider == 0) continue;
    const Tick due = (tick / item.divider + 1) * item.divider;
    next = std::min(next.value_or(due), due);
  }
  return next;
}

// ---- States and messages

void XbusDevice::send(std::uint8_t id, std::span<const std::uint8_t> data) { put_out(xbus_frame(id, data)); }

void XbusDevice::enter(State state, Tick now) {
  state_ = state;
  next_due_ = kNever;
  if (state == State::booting) next_due_ = now + ticks_of(magnitudes_.boot_s);
  if (state == State::waking) next_due_ = now + ticks_of(magnitudes_.wake_up_s);
  if (state == State::measuring) {
    if (const auto packet = plan_.next_packet(now - start_)) next_due_ = start_ + *packet;
  }
}

void XbusDevice::boot(Tick now) {
  start_ = now;
  packet_counter_ = 0;
  parser_.clear();
  unit_.start();
  enter(State::booting, now);
}

void XbusDevice::switch_power(bool on, Tick now) {
  if (on) {
    boot(now);
  } else {
    unit_.stop();
    enter(State::off, now);
  }
}

void XbusDevice::advance_to(Tick now, const Attitude& fixture) {
  if (now < next_due_) return;
  switch (state_) {
    case State::booting:
      send(kXbusWakeUp);
      enter(State::waking, now);
      break;
    case State::waking:
      enter(State::measuring, now);
      break;
    case State::measuring:
      unit_.advance_to(static_cast<std::uint64_t>(now - start_));
      send(kMtData2, packet(now - start_, fixture));
      ++packet_counter_;
      enter(State::measuring, now);
      break;
    case State::off:
    case State::configuring:
      break;
  }
}

void XbusDevice::receive(std::span<const std::uint8_t> bytes, Tick now) {
  parser_.feed(bytes);
  while (const auto message = parser_.next()) {
    if (state_ != State::off && state_ != State::booting) answer(*message, now);
  }
}

void XbusDevice::answer(const XbusMessage& message, Tick now) {
  switch (message.id) {
    case kGotoConfig:
      send(acknowledged(message.id));
      enter(State::configuring, now);
      return;
    case kGotoMeasurement:
      send(acknowledged(message.id));
      enter(State::measuring, now);
      return;
    case kXbusReset:
      send(acknowledged(message.id));
      boot(now);
      return;
    case kWakeUpAck:
      if (state_ == State::waking) enter(State::configuring, now);
      return;
    default:
      break;
  }
  if (state_ == State::configuring) {
    answer_configuring(message);
  } else {
    send(kXbusError, {{kInvalidMessage}});
  }
}

void XbusDevice::answer_configuring(const XbusMessage& message) {
  base::Bytes data;
  switch (message.id) {
    case kReqDeviceId:
      base::append_big_endian(data, unit_.device_id());
      break;
    case kReqProductCode:
      data.assign(kProductCode.begin(), kProductCode.end());
      break;
    case kReqFirmware:
      data.assign(std::begin(kXbusFirmware), std::end(kXbusFirmware));
      break;
    case kOutputConfiguration:
      configure_output(message);
      return;
    default:
      send(kXbusError, {{kInvalidMessage}});
      return;
  }
  send(acknowledged(message.id), data);
}

void XbusDevice::configure_output(const XbusMessage& message) {
  if (!message.data.empty()) {
    const auto plan = OutputPlan::parse(message.data);
    if (!plan) {
      send(kXbusError, {{kInvalidParameter}});
      return;
    }
    plan_ = *plan;
  }
  send(acknowledged(message.id), plan_.data());
}

base::Bytes XbusDevice::packet(Tick since_start, const Attitude& fixture) const {
  const auto index = static_cast<std::uint64_t>(since_start);
  base::Bytes data;
  std::uint32_t status = kSelfTestOk | kFilterValid;
  std::optional<std::size_t> status_at;  // filled in last: all sensors have a say in it
  const auto append = [&](const OutputItem& item, const SensedVector& sensed, unsigned first_clip_bit) {
    status |= clip_bits(sensed, first_clip_bit);
    append_item_header(data, item.id, 12);
    for (const float value : sensed.value) base::append_big_endian(data, std::bit_cast<std::uint32_t>(value));
  };
  for (const OutputItem& item : plan_.items()) {
    if (!OutputPlan::due(item, since_start)) continue;
    if (item.id == kPacketCounter) {
      append_item_header(data, item.id, 2);
      base::append_big_endian(data, packet_counter_);
    } else if (item.id == kSampleTimeFine) {
      append_item_header(data, item.id, 4);
      base::append_big_endian(data, static_cast<std::uint32_t>(since_start * kFineTimePerTick));
    } else if (item.id == kTemperature) {
      append_item_header(data, item.id, 4);
      base::append_big_endian(data, std::bit_cast<std::uint32_t>(unit_.thermometer_c(index)));
    } else if (item.id == kAcceleration) {
      append(item, unit_.acceleration(fixture, index, item.rate_hz()), kClipAcceleration);
    } else if (item.id == kRateOfTurn) {
      append(item, unit_.rate_of_turn(fixture, index, item.rate_hz()), kClipRate);
    } else {
      append_item_header(data, item.id, 4);
      status_at = data.size();
      base::append_big_endian(data, std::uint32_t{0});
    }
  }
  if (status_at) {
    base::Bytes word;
    base::append_big_endian(word, status);
    std::copy(word.begin(), word.end(), data.begin() + static_cast<std::ptrdiff_t>(*status_at));
  }
  return data;
}

std::unique_ptr<UnitElectronics> make_xbus_device(const CampaignConfig& config, int number) {
  return std::make_unique<XbusDevice>(config, number);
}

}  // namespace soak::hal::sim
