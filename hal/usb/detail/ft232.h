// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/bytes.h"
#include "hal/usb/detail/usb_handle.h"

namespace soak::hal::usb {

/// The number for a baud rate: 3 MHz by eighths, whose code stands in the two upper bits of the value and in the index.
struct Ft232Divisor {
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// Nothing for a rate that the chip misses by more than 3 %, the most that a serial line bears.
[[nodiscard]] std::optional<Ft232Divisor> ft232_divisor(int baud);

/// Appends to `bytes` what a transfer brought without the two status bytes at the head of each packet of
/// `packet_size`.
void append_without_status(std::span<const std::uint8_t> transfer, std::size_t packet_size, base::Bytes& bytes);

/// Makes the chip a serial line 8N1 without flow control, with DTR and RTS on, and drops what it still has from before.
/// Errors: bad_input for a baud rate that it does not have, `device`.
[[nodiscard]] base::Status set_up_ft232(UsbHandle& handle, int baud);

}  // namespace soak::hal::usb
