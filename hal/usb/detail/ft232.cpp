// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/ft232.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace soak::hal::usb {
namespace {

constexpr std::size_t kStatusSize = 2;
constexpr double kClock_hz = 3e6;
constexpr double kMostDeviation = 0.03;
/// Codes of 0/8 … 7/8.
constexpr std::array<unsigned, 8> kFractionCodes = {0, 3, 2, 4, 1, 5, 6, 7};
constexpr unsigned kMostDivisor = 0x3FFF;

/// Requests of the chip, with values in the order in which they are sent.
struct Request {
  std::uint8_t request;
  std::uint16_t value;
};
constexpr std::uint8_t kBaud = 3;
constexpr std::array kRequests = {
    Request{0, 0},       // reset
    Request{0, 2},       // drop stale input
    Request{0, 1},       // drop stale output
    Request{4, 0x0008},  // 8 bits, no parity, 1 stop bit
    Request{2, 0},       // no flow control
    Request{9, 8},       // ms until a packet that is not full is sent
    Request{1, 0x0101},  // DTR on
    Request{1, 0x0202},  // RTS on
};

}  // namespace

std::optional<Ft232Divisor> ft232_divisor(int baud) {
  if (baud <= 0) return std::nullopt;
  const auto eighths = static_cast<unsigned>(std::lround(std::min(8.0 * kClock_hz / baud, 1e9)));
  if (eighths < 8 || eighths / 8 > kMostDivisor) return std::nullopt;
  if (std::abs(8.0 * kClock_hz / eighths - baud) > kMostDeviation * baud) return std::nullopt;
  // Between 3 and 1.5 megabaud the chip knows 2 only, and writes both ends in its own way.
  if (eighths == 8) return Ft232Divisor{0, 0};
  if (eighths == 12) return Ft232Divisor{1, 0};
  if (eighths < 16) return std::nullopt;
  const unsigned code = kFractionCodes[eighths % 8];
  return Ft232Divisor{static_cast<std::uint16_t>(eighths / 8 | (code & 3U) << 14U),
                      static_cast<std::uint16_t>(code >> 2U)};
}

void append_without_status(std::span<const std::uint8_t> transfer, std::size_t packet_size, base::Bytes& bytes) {
  while (transfer.size() > kStatusSize) {
    const auto packet = transfer.first(std::min(transfer.size(), packet_size));
    bytes.insert(bytes.end(), packet.begin() + kStatusSize, packet.end());
    transfer = transfer.subspan(packet.size());
  }
}

base::Status set_up_ft232(UsbHandle& handle, int baud) {
  const auto divisor = ft232_divisor(baud);
  if (!divisor) return base::bad_input(fmt::format("the chip has no {} baud: 184 to 3000000 (docs/hardware.md)", baud));
  for (const Request& request : kRequests) {
    if (auto done = handle.vendor_request(request.request, request.value, 0); !done) return done;
  }
  return handle.vendor_request(kBaud, divisor->value, divisor->index);
}

}  // namespace soak::hal::usb
