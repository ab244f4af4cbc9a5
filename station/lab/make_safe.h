// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "hal/devices/chamber.h"

namespace soak::station {

/// What a chamber does after make_chamber_safe().
enum class SafeAction : std::uint8_t {
  driven,        ///< on the way to the safe temperature; heating and cooling stay on when it is there
  switched_off,  ///< heating and cooling were switched off
  left_off,      ///< they were off
};

struct MadeSafe {
  SafeAction action = SafeAction::left_off;
  double target_c = 0.0;                       ///< the safe temperature
  std::string why_off;                         ///< why it was switched off instead of driven; empty otherwise
  std::optional<hal::ChamberReading> reading;  ///< after the last command; nothing of one that cannot be read
};

/// How long make_chamber_safe() tries.
struct MakeSafePatience {
  std::chrono::milliseconds silence{30000};  ///< for a chamber that does not answer, or whose readings are impossible
  std::chrono::milliseconds pause{1000};  ///< between two tries: controllers keep set points in memory that wears out
};

/// Brings a chamber that nobody controls into the safe state, once and without waiting for the temperature; the program
/// that runs it may be the last one that ever reaches the chamber. It is the beginning of what SafeEnd does:
/// - an alarm that asks for it (in two readings in a row), readings that nobody can believe: off at once;
/// - off already: left off, the room warms it;
/// - on, and within 1 K of safe_temp_c(): off;
/// - on, elsewhere: ramp off, set point to safe_temp_c(), both read back. One that does not take it in five tries: off.
/// Calls block and sleep. Errors (device): the chamber does not answer, or cannot be switched off.
[[nodiscard]] base::Result<MadeSafe> make_chamber_safe(hal::Chamber& chamber, double dew_point_c,
                                                       const MakeSafePatience& patience = {});

}  // namespace soak::station
