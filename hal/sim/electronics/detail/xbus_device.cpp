// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_device.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string_view>

namespace soak::hal::sim {
namespace {

constexpr std::uint8_t kReqDeviceId = 0x00;
constexpr std::uint8_t kGotoMeasurement = 0x10;
constexpr std::uint8_t kReqFirmware = 0x12;
constexpr std::uint8_t kReqProductCode = 0x1C;
constexpr std::uint8_t kGotoConfig = 0x30;
constexpr std::uint8_t kMtData2 = 0x36;
constexpr std::uint8_t kWakeUp = 0x3E;
constexpr std::uint8_t kWakeUpAck = 0x3F;
constexpr std::uint8_t kReset = 0x40;
constexpr std::uint8_t kError = 0x42;
constexpr std::uint8_t kOutputConfiguration = 0xC0;

constexpr std::uint8_t kInvalidMessage = 0x04;
constexpr std::uint8_t kInvalidParameter = 0x21;

constexpr std::string_view kProductCode = "MTi-300-SIMULATED   ";
constexpr std::uint8_t kFirmware[] = {1, 8, 2};
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
  append_u16(data, id);
  data.push_back(size);
}

}  // namespace

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
      send(kWakeUp);
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
    case kReset:
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
    send(kError, {{kInvalidMessage}});
  }
}

void XbusDevice::answer_configuring(const XbusMessage& message) {
  base::Bytes data;
  switch (message.id) {
    case kReqDeviceId:
      append_u32(data, unit_.device_id());
      break;
    case kReqProductCode:
      data.assign(kProductCode.begin(), kProductCode.end());
      break;
    case kReqFirmware:
      data.assign(std::begin(kFirmware), std::end(kFirmware));
      break;
    case kOutputConfiguration:
      configure_output(message);
      return;
    default:
      send(kError, {{kInvalidMessage}});
      return;
  }
  send(acknowledged(message.id), data);
}

void XbusDevice::configure_output(const XbusMessage& message) {
  if (!message.data.empty()) {
    const auto plan = OutputPlan::parse(message.data);
    if (!plan) {
      send(kError, {{kInvalidParameter}});
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
    for (const float value : sensed.value) append_f32(data, value);
  };
  for (const OutputItem& item : plan_.items()) {
    if (!OutputPlan::due(item, since_start)) continue;
    if (item.id == kPacketCounter) {
      append_item_header(data, item.id, 2);
      append_u16(data, packet_counter_);
    } else if (item.id == kSampleTimeFine) {
      append_item_header(data, item.id, 4);
      append_u32(data, static_cast<std::uint32_t>(since_start * kFineTimePerTick));
    } else if (item.id == kTemperature) {
      append_item_header(data, item.id, 4);
      append_f32(data, unit_.thermometer_c(index));
    } else if (item.id == kAcceleration) {
      append(item, unit_.acceleration(fixture, index, item.rate_hz()), kClipAcceleration);
    } else if (item.id == kRateOfTurn) {
      append(item, unit_.rate_of_turn(fixture, index, item.rate_hz()), kClipRate);
    } else {
      append_item_header(data, item.id, 4);
      status_at = data.size();
      append_u32(data, 0);
    }
  }
  if (status_at) {
    base::Bytes word;
    append_u32(word, status);
    std::copy(word.begin(), word.end(), data.begin() + static_cast<std::ptrdiff_t>(*status_at));
  }
  return data;
}

}  // namespace soak::hal::sim
