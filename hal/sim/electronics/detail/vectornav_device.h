// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/sim/electronics/unit_electronics.h"

namespace soak::hal::sim {

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

}  // namespace soak::hal::sim
