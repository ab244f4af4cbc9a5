// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>

/// Where a device is reached.
namespace soak::hal {

struct TcpAddress {
  std::string host;
  int port = 0;
};

struct SerialAddress {
  std::string device;  ///< also a pseudo-terminal
  int baud = 115200;
  char parity = 'N';  ///< this and `stop_bits`: of controllers on Modbus, else 8N1
  int stop_bits = 1;
};

/// A device on the bus, without the kernel's driver: a chip of FTDI (vendor 0403, and 2639:0300 with such a chip
/// inside) is a serial line, any other a pair of bulk endpoints.
struct UsbAddress {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial;  ///< of the device's descriptor; empty = any
  std::string path;    ///< of the socket, as "1-4.2": bus, then ports; empty = any
  int baud = 115200;   ///< of a serial line
};

/// Bytes as they once arrived; nobody answers. Its end is that of the connection, an error with kRecordingEnded.
struct RecordedAddress {
  std::string file;
};
inline constexpr const char* kRecordingEnded = "the recording has ended";

/// Where a unit's bytes come from.
using UnitAddress = std::variant<TcpAddress, SerialAddress, UsbAddress, RecordedAddress>;

/// Where a controller of a chamber, a fixture or of unit power answers.
using ControllerAddress = std::variant<TcpAddress, SerialAddress>;

/// "tcp 10.0.0.9:4001", "serial /dev/ttyUSB0", "usb 2639:0013 1-4.2": what two units cannot share.
[[nodiscard]] std::string text_of(const UnitAddress& address);

/// "10.0.0.9:502" or "/dev/ttyUSB0".
[[nodiscard]] std::string text_of(const ControllerAddress& address);

}  // namespace soak::hal
