// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// What an output shall deliver; absent = what the supply is set to at its front.
struct SupplySettings {
  std::optional<double> voltage_v;
  std::optional<double> limit_a;  ///< current that the supply does not exceed
};

/// What an output says of itself at one moment; nothing where the device does not tell it.
struct OutputReading {
  bool on = false;
  bool tripped = false;  ///< a protection of the supply has switched it off
  std::optional<double> voltage_v;
  std::optional<double> current_a;
  std::optional<double> limit_a;
};

/// What switches the supply of the units, output by output, counted from 1: relays, a laboratory supply, the event
/// outputs of a chamber's controller, ports of USB hubs. The rules of Chamber's calls hold.
class UnitPower {
 public:
  UnitPower() = default;
  UnitPower(const UnitPower&) = delete;
  UnitPower& operator=(const UnitPower&) = delete;
  virtual ~UnitPower() = default;

  [[nodiscard]] virtual base::Status connect() = 0;
  /// Refuses (bad_input) an output that is not there and settings that it cannot take. Asks nobody.
  [[nodiscard]] virtual base::Status check(int output, const SupplySettings& settings) const = 0;
  /// Gives an output its voltage and its current limit, read back. Does not switch it.
  [[nodiscard]] virtual base::Status prepare(int output, const SupplySettings& settings) = 0;
  /// Read back.
  [[nodiscard]] virtual base::Status set(int output, bool on) = 0;
  /// All of them in one call: many supplies answer for several outputs at once.
  [[nodiscard]] virtual base::Result<std::map<int, OutputReading>> read(const std::vector<int>& outputs) = 0;
  /// Whether the output tells its voltage or its current.
  [[nodiscard]] virtual bool measures(int output) const = 0;
  [[nodiscard]] virtual std::string description() const = 0;
};

/// Refuses (bad_input) a map of another kind, or one that lacks what every supply and relay needs. Nothing is opened
/// yet.
[[nodiscard]] base::Result<std::unique_ptr<UnitPower>> make_unit_power(const DeviceMap& map);

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

}  // namespace soak::hal
