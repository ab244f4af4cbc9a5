// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace soak::station {

/// A serial port of this machine.
struct SerialPort {
  std::string device;  ///< the name that stays the same when it is plugged in again, where it has one
  std::string node;    ///< "/dev/ttyUSB0"
};

/// The serial ports in `devices` (/dev): those of adapters by their lasting names first, then what has none. Ports that
/// the kernel names without hardware behind them (most ttyS) are left out: `drivers` is /sys/class/tty.
[[nodiscard]] std::vector<SerialPort> serial_ports(const std::filesystem::path& devices,
                                                   const std::filesystem::path& drivers);

/// The maps of a folder that can be read, in the order of their files: `file` (its name), `name`, `protocol`, and what
/// the configuration takes for an address where nothing else is entered: `port`, `baud`, `unit` (null: none).
[[nodiscard]] nlohmann::json map_choices(const std::filesystem::path& folder);

/// One of them, `choice` as its `file`; null where it cannot be read.
[[nodiscard]] nlohmann::json map_choice(const std::filesystem::path& file, const std::string& choice);

}  // namespace soak::station
