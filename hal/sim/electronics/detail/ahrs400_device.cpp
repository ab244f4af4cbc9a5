// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string_view>

#include "base/bytes.h"
#include "base/units.h"

#include "hal/sim/electronics/unit_electronics.h"

namespace soak::hal::sim {
namespace {

constexpr double kRange_dps = 100.0;
constexpr double kRange_g = 2.0;
/// Nominal range, and half of it beyond.
constexpr double kFullScale = 32768.0 / 1.5;
constexpr double kTimerTick_s = 0.79e-6;
constexpr std::string_view kVersion = "AHRS400CC-100 SIMULATED ver 1.15";
constexpr std::size_t kPacketSize = 24;
constexpr std::uint8_t kHeader = 0xFF;
/// What rate the noise of a number belongs to: that of the packets, on average.
constexpr double kMeanStep = 19.0 / 3.0;
constexpr double kRate_hz = static_cast<double>(kTicksPerSecond) / kMeanStep;

std::uint16_t number_of(double share_of_range) {
  return static_cast<std::uint16_t>(
      static_cast<std::int16_t>(std::clamp(std::round(share_of_range * kFullScale), -32767.0, 32767.0)));
}

std::uint16_t number_of_temp(double temp_c) {
  const double volts = temp_c / 44.44 + 1.375;
  return static_cast<std::uint16_t>(std::clamp(std::round(volts * 4096.0 / 5.0), 0.0, 4095.0));
}

std::uint8_t ahrs400_sum_of(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), 0U));
}

/// A Crossbow AHRS400 of 100 °/s and 2 g: commands of one byte; in scaled mode packets of 24 bytes, asked for one by
/// one (G) or sent without being asked (C) every sixth or seventh internal sample. Wakes up idle and forgets what it
/// was told. The modes "voltage" and "angle" are known by name only: nothing is measured in them.
class Ahrs400Device final : public UnitElectronics {
 public:
  using UnitElectronics::UnitElectronics;

  void switch_power(bool on, Tick now) override;
  void receive(std::span<const std::uint8_t> bytes, Tick now) override;
  void advance_to(Tick now, const Attitude& fixture) override;
  [[nodiscard]] bool streams() const override { return state_ == State::streaming; }

 private:
  enum class State : std::uint8_t { off, booting, idle, streaming };

  void obey(char command, Tick now);
  void tell_serial_number();
  /// Ticks from packet number `sent_` to the next.
  [[nodiscard]] Tick step() const;
  void send_packet(Tick now, const Attitude& fixture);

  State state_ = State::off;
  bool scaled_ = false;
  std::uint64_t sent_ = 0;
};

void Ahrs400Device::switch_power(bool on, Tick now) {
  scaled_ = false;
  sent_ = 0;
  state_ = on ? State::booting : State::off;
  set_power(on, now);
}

void Ahrs400Device::receive(std::span<const std::uint8_t> bytes, Tick now) {
  if (state_ == State::off || state_ == State::booting) return;
  for (const std::uint8_t byte : bytes) obey(static_cast<char>(byte), now);
}

void Ahrs400Device::obey(char command, Tick now) {
  const auto stop = [&] {
    state_ = State::idle;
    next_due_ = kNever;
  };
  const auto answer = [&](char word) { put_out({{static_cast<std::uint8_t>(word)}}); };
  switch (command) {
    case 'R':
      stop();
      scaled_ = false;
      answer('H');
      return;
    case 'r':
    case 'a':
    case 'c':
      scaled_ = command == 'c';
      answer(static_cast<char>(command - 'a' + 'A'));
      return;
    case 'P':
      stop();
      return;
    case 'G':
      stop();
      if (scaled_) next_due_ = now + 1;
      return;
    case 'C':
      if (!scaled_) return;
      state_ = State::streaming;
      next_due_ = now + step();
      return;
    case 'S':
      tell_serial_number();
      return;
    case 'v':
      put_out({reinterpret_cast<const std::uint8_t*>(kVersion.data()), kVersion.size()});
      return;
    default:
      return;
  }
}

void Ahrs400Device::tell_serial_number() {
  base::Bytes answer{kHeader};
  base::append_big_endian(answer, unit_.device_id());
  answer.push_back(ahrs400_sum_of(std::span(answer).subspan(1)));
  put_out(answer);
}

/// Its own loop sends every third sample or so.
Tick Ahrs400Device::step() const { return sent_ % 3 == 2 ? 7 : 6; }

void Ahrs400Device::advance_to(Tick now, const Attitude& fixture) {
  if (now < next_due_) return;
  if (state_ == State::booting) {
    state_ = State::idle;
    next_due_ = kNever;
    return;
  }
  send_packet(now, fixture);
  next_due_ = state_ == State::streaming ? now + step() : kNever;
}

void Ahrs400Device::send_packet(Tick now, const Attitude& fixture) {
  const auto index = static_cast<std::uint64_t>(now - start_);
  unit_.advance_to(index);
  const SensedVector rate = unit_.rate_of_turn(fixture, index, kRate_hz);
  const SensedVector accel = unit_.acceleration(fixture, index, kRate_hz);
  const double time_s = static_cast<double>(index) / static_cast<double>(kTicksPerSecond);
  base::Bytes packet{kHeader};
  packet.reserve(kPacketSize);
  for (const float rps : rate.value) base::append_big_endian(packet, number_of(rps * base::kDegPerRad / kRange_dps));
  for (const float mps2 : accel.value)
    base::append_big_endian(packet, number_of(mps2 / base::kStandardGravity_mps2 / kRange_g));
  for (int axis = 0; axis < 3; ++axis)
    base::append_big_endian(packet, std::uint16_t{0});  // no magnetic field in this laboratory
  base::append_big_endian(packet, number_of_temp(unit_.thermometer_c(index)));
  base::append_big_endian(
      packet, static_cast<std::uint16_t>(0xFFFF - static_cast<std::uint64_t>(time_s / kTimerTick_s) % 0x10000));
  packet.push_back(ahrs400_sum_of(std::span(packet).subspan(1)));
  put_out(packet);
  ++sent_;
}

}  // namespace

std::unique_ptr<UnitElectronics> make_ahrs400_device(const CampaignConfig& config, int number) {
  return std::make_unique<Ahrs400Device>(config, number);
}

}  // namespace soak::hal::sim
