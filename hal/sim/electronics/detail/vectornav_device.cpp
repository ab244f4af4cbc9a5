// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"

#include "hal/sim/electronics/unit_electronics.h"

namespace soak::hal::sim {
namespace {

constexpr std::string_view kVectorNavModel = "VN-200T-SIMULATED";
constexpr std::string_view kVectorNavFirmware = "2.1.0.0";
/// Lines that are sent unasked: 40 a second.
constexpr Tick kLinePeriod = kTicksPerSecond / 40;
constexpr std::size_t kLongestLine = 256;

// Fields of binary outputs.
constexpr std::uint16_t kTimeStartup = 1U << 0U;
constexpr std::uint16_t kCommonRate = 1U << 5U;
constexpr std::uint16_t kCommonAccel = 1U << 8U;
constexpr std::uint16_t kImuTemp = 1U << 4U;
constexpr std::uint16_t kImuAccel = 1U << 9U;
constexpr std::uint16_t kImuRate = 1U << 10U;
constexpr std::uint16_t kSaturation = 1U << 11U;
constexpr std::uint16_t kKnownCommon = kTimeStartup | kCommonRate | kCommonAccel;
constexpr std::uint16_t kKnownImu = kImuTemp | kImuAccel | kImuRate | kSaturation;
// Saturation flags.
constexpr unsigned kAccelSaturated = 3;
constexpr unsigned kRateSaturated = 6;

enum class ErrorCode { bad_check = 3, bad_command = 4, too_few = 5, bad_parameter = 7, bad_register = 8 };

std::string error_line(ErrorCode code) { return fmt::format("VNERR,{:02d}", static_cast<int>(code)); }

unsigned exclusive_or(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return sum;
}

/// CRC-16 of polynomial 0x1021 that begins with 0.
std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8U) | (crc << 8U & 0xFFFFU);
    crc ^= byte;
    crc ^= (crc & 0xFFU) >> 4U;
    crc ^= crc << 12U & 0xFFFFU;
    crc ^= (crc & 0xFFU) << 5U;
  }
  return static_cast<std::uint16_t>(crc);
}

void append(base::ByteWriter& data, const SensedVector& sensed) {
  for (const float value : sensed.value) data.write(value);
}

unsigned flags_of(const SensedVector& sensed, unsigned first) {
  unsigned flags = 0;
  for (unsigned axis = 0; axis < 3; ++axis) flags |= sensed.clipped[axis] ? 1U << (first + axis) : 0U;
  return flags;
}

/// A VectorNav VN-200 on its serial port 1: registers 1, 3, 4 (who it is), 6 (lines, on after each start) and 75
/// (binary output 1, off after each start), 400 Hz divided by a whole number. Of the binary output's fields it has the
/// time since startup, rate of turn and acceleration (groups 1 and 3), temperature and the saturation flags.
class VectorNavDevice final : public UnitElectronics {
 public:
  using UnitElectronics::UnitElectronics;

  void switch_power(bool on, Tick now) override;
  void receive(std::span<const std::uint8_t> bytes, Tick now) override;
  void advance_to(Tick now, const Attitude& fixture) override;
  [[nodiscard]] bool streams() const override { return divisor_ > 0; }

 private:
  enum class State : std::uint8_t { off, booting, running };
  /// Fields of the binary output, as masks of their groups.
  struct Fields {
    std::uint16_t common = 0;
    std::uint16_t imu = 0;
  };

  void obey(std::string_view line, Tick now);
  [[nodiscard]] std::string answer(std::string_view command, Tick now);
  [[nodiscard]] std::string configure(std::string_view command, Tick now);
  void send_line(std::string_view text);
  void send_asynchronous_line();
  void send_packet(Tick since_start, const Attitude& fixture);
  void plan(Tick now);

  State state_ = State::off;
  bool lines_ = true;
  Tick divisor_ = 0;  ///< of output 1; 0 = off
  Fields fields_;
  std::string pending_;
};

void VectorNavDevice::switch_power(bool on, Tick now) {
  lines_ = true;
  divisor_ = 0;
  pending_.clear();
  state_ = on ? State::booting : State::off;
  set_power(on, now);
}

void VectorNavDevice::receive(std::span<const std::uint8_t> bytes, Tick now) {
  if (state_ != State::running) return;
  pending_.append(bytes.begin(), bytes.end());
  for (auto end = pending_.find('\n'); end != std::string::npos; end = pending_.find('\n')) {
    obey(std::string_view(pending_).substr(0, end), now);
    pending_.erase(0, end + 1);
  }
  if (pending_.size() > kLongestLine) pending_.clear();
}

void VectorNavDevice::obey(std::string_view line, Tick now) {
  const auto begin = line.find('$');
  const auto star = line.find('*');
  if (begin == std::string_view::npos || star == std::string_view::npos || star < begin) return;
  const std::string_view command = line.substr(begin + 1, star - begin - 1);
  const std::string_view check = line.substr(star + 1, 2);
  const bool right = check == "XX" || check == fmt::format("{:02X}", exclusive_or(command));
  send_line(right ? answer(command, now) : error_line(ErrorCode::bad_check));
}

std::string VectorNavDevice::answer(std::string_view command, Tick now) {
  if (command == "VNRRG,01") return fmt::format("VNRRG,01,{}", kVectorNavModel);
  if (command == "VNRRG,03") return fmt::format("VNRRG,03,{:010}", unit_.device_id());
  if (command == "VNRRG,04") return fmt::format("VNRRG,04,{}", kVectorNavFirmware);
  if (command.starts_with("VNWRG,75,")) return configure(command, now);
  if (command == "VNWRG,06,0" || command == "VNWRG,06,14") {
    lines_ = command == "VNWRG,06,14";
    plan(now);
    return std::string(command);
  }
  const bool about_registers = command.starts_with("VNRRG,") || command.starts_with("VNWRG,");
  return error_line(about_registers ? ErrorCode::bad_register : ErrorCode::bad_command);
}

/// Register 75: serial port, divisor, groups, masks of the groups.
std::string VectorNavDevice::configure(std::string_view command, Tick now) {
  unsigned port = 0;
  unsigned divisor = 0;
  unsigned groups = 0;
  unsigned common = 0;
  unsigned imu = 0;
  if (std::sscanf(std::string(command).c_str(), "VNWRG,75,%u,%u,%x,%x,%x", &port, &divisor, &groups, &common, &imu) !=
      5)
    return error_line(ErrorCode::too_few);
  const bool known = (common & ~unsigned{kKnownCommon}) == 0 && (imu & ~unsigned{kKnownImu}) == 0;
  if (port != 1 || groups != 5 || !known || divisor > static_cast<unsigned>(kTicksPerSecond))
    return error_line(ErrorCode::bad_parameter);
  divisor_ = static_cast<Tick>(divisor);
  fields_ = {static_cast<std::uint16_t>(common), static_cast<std::uint16_t>(imu)};
  plan(now);
  return std::string(command);
}

void VectorNavDevice::plan(Tick now) {
  const auto next_of = [&](Tick period) { return start_ + ((now - start_) / period + 1) * period; };
  next_due_ = kNever;
  if (lines_) next_due_ = next_of(kLinePeriod);
  if (divisor_ > 0) next_due_ = std::min(next_due_, next_of(divisor_));
}

void VectorNavDevice::advance_to(Tick now, const Attitude& fixture) {
  if (now < next_due_) return;
  const Tick since_start = now - start_;
  if (state_ == State::booting) {
    state_ = State::running;
  } else {
    if (divisor_ > 0 && since_start % divisor_ == 0) send_packet(since_start, fixture);
    if (lines_ && since_start % kLinePeriod == 0) send_asynchronous_line();
  }
  plan(now);
}

void VectorNavDevice::send_line(std::string_view text) {
  const std::string line = fmt::format("${}*{:02X}\r\n", text, exclusive_or(text));
  put_out({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
}

/// Only that it comes matters: nobody reads what it says.
void VectorNavDevice::send_asynchronous_line() {
  send_line(
      "VNYMR,+000.000,+000.000,+000.000,+0.0000,+0.0000,+0.0000,+00.000,+00.000,-09.807,+0.000000,+0.000000,+0.000000");
}

void VectorNavDevice::send_packet(Tick since_start, const Attitude& fixture) {
  const auto index = static_cast<std::uint64_t>(since_start);
  const double rate_hz = static_cast<double>(kTicksPerSecond) / static_cast<double>(divisor_);
  unit_.advance_to(index);
  const SensedVector rate = unit_.rate_of_turn(fixture, index, rate_hz);
  const SensedVector accel = unit_.acceleration(fixture, index, rate_hz);
  base::ByteWriter data;
  data.write(std::uint8_t{0x05});
  data.write(fields_.common);
  data.write(fields_.imu);
  if ((fields_.common & kTimeStartup) != 0) data.write(index * (1'000'000'000ULL / kTicksPerSecond));
  if ((fields_.common & kCommonRate) != 0) append(data, rate);
  if ((fields_.common & kCommonAccel) != 0) append(data, accel);
  if ((fields_.imu & kImuTemp) != 0) data.write(unit_.thermometer_c(index));
  if ((fields_.imu & kImuAccel) != 0) append(data, accel);
  if ((fields_.imu & kImuRate) != 0) append(data, rate);
  if ((fields_.imu & kSaturation) != 0)
    data.write(static_cast<std::uint16_t>(flags_of(accel, kAccelSaturated) | flags_of(rate, kRateSaturated)));
  const std::uint16_t crc = crc16(data.bytes());
  put_out({{0xFA}});
  put_out(data.bytes());
  put_out({{static_cast<std::uint8_t>(crc >> 8U), static_cast<std::uint8_t>(crc & 0xFFU)}});
}

}  // namespace

std::unique_ptr<UnitElectronics> make_vectornav_device(const CampaignConfig& config, int number) {
  return std::make_unique<VectorNavDevice>(config, number);
}

}  // namespace soak::hal::sim
