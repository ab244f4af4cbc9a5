// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "hal/devices/chamber.h"
#include "hal/devices/fixture.h"
#include "hal/devices/unit_power.h"
#include "hal/imu/imu.h"
#include "hal/maps/device_map.h"

/// Makes the devices that a station's configuration names. Nothing is opened yet.
namespace soak::hal {

/// Refuses (bad_input) a map that lacks a quantity which every chamber needs.
[[nodiscard]] base::Result<std::unique_ptr<Chamber>> make_modbus_chamber(const RegisterMap& map);
[[nodiscard]] base::Result<std::unique_ptr<Fixture>> make_modbus_fixture(const RegisterMap& map);
[[nodiscard]] base::Result<std::unique_ptr<UnitPower>> make_modbus_power(const RegisterMap& map);

/// Hubs on the USB that switch the supply of their ports, each by its socket, as "1-4" or "usb1" (a root hub).
struct UsbHubs {
  std::vector<std::string> paths;
};
/// Output 100 (h - 1) + p is port p of hub h, both counted from 1. Of a port of USB 3 both halves are switched. Many
/// hubs say that they switched and did not: only the unit proves it.
/// `devices`: the kernel's folder of USB devices.
[[nodiscard]] std::unique_ptr<UnitPower> make_usb_hub_power(
    const UsbHubs& hubs, const std::filesystem::path& devices = "/sys/bus/usb/devices");

/// Whether this process may switch that output. Switches nothing. Error `device`: no such hub or port, no permission...
[[nodiscard]] base::Status may_switch(const UsbHubs& hubs, int output,
                                      const std::filesystem::path& devices = "/sys/bus/usb/devices");

/// Where a unit's bytes come from.
struct TcpAddress {
  std::string host;
  int port = 0;
};
struct SerialAddress {
  std::string device;  ///< also a pseudo-terminal
  int baud = 115200;
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
/// Bytes as they once arrived; nobody answers. Its end is that of the connection, an error with this message.
struct RecordedAddress {
  std::string file;
};
inline constexpr const char* kRecordingEnded = "the recording has ended";
using UnitAddress = std::variant<TcpAddress, SerialAddress, UsbAddress, RecordedAddress>;

/// "tcp 10.0.0.9:4001", "serial /dev/ttyUSB0", "usb 2639:0013 1-4.2": what two units cannot share.
[[nodiscard]] std::string text_of(const UnitAddress& address);

/// What a unit speaks.
enum class UnitDecoder : std::uint8_t { xsens, ahrs400, vectornav };

/// Nominal ranges of a Crossbow AHRS400, from its label: the scale of its numbers.
struct Ahrs400Ranges {
  double rate_dps = 0.0;
  double accel_g = 0.0;
};

struct UnitLink {
  UnitAddress address;
  UnitDecoder decoder = UnitDecoder::xsens;
  Ahrs400Ranges ranges = {};  ///< for ahrs400 only
};

/// Any decoder over any address.
[[nodiscard]] std::unique_ptr<Imu> make_imu(const UnitLink& link);

}  // namespace soak::hal
