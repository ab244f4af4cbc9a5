// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"

/// Numbers as registers carry them.
namespace soak::hal {

using Words = std::vector<std::uint16_t>;

/// A decimals register that holds more is a wrong register.
inline constexpr int kMaxDecimals = 6;

/// Registers that a value takes.
[[nodiscard]] int word_count(RegisterType type);

/// The value that `words` carry. `decimals` is the content of the place's decimals register, 0 without one.
[[nodiscard]] double decode_value(const RegisterPlace& place, std::span<const std::uint16_t> words, int decimals);

/// The words that carry `value`, rounded to the register's resolution. Refuses (bad_input) a value that the type cannot
/// hold.
[[nodiscard]] base::Result<Words> encode_value(const RegisterPlace& place, double value, int decimals);

/// Whether two contents mean one value. Controllers that compute in other units give a float back with another last
/// digit: floats may differ by 0.001.
[[nodiscard]] bool same_value(const RegisterPlace& place, std::span<const std::uint16_t> a,
                              std::span<const std::uint16_t> b);

/// Whether an alarm's register that holds `content` says that the alarm is active.
[[nodiscard]] bool says_alarm(const RegisterAlarm& alarm, int content);

/// "register 7" or "registers 7 to 8".
[[nodiscard]] std::string registers_text(int address, int count);

}  // namespace soak::hal
