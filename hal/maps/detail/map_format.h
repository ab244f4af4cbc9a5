// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

/// What of a map's file depends on what its controller speaks. Each function reads one table; mistakes are recorded in
/// it.
struct MapFormat {
  MapProtocol protocol;
  std::vector<std::pair<std::string_view, std::string>> kinds;  ///< of devices that may speak so, each twice
  LinkSettings (*read_link)(const settings::Table& link);
  Quantity (*read_quantity)(const settings::Table& table);
  void (*read_probe)(const settings::Table& table, Probe& probe);
  void (*read_alarm)(const settings::Table& table, AlarmRule& rule);
  /// Whether the controller's form of the quantity can hold the value.
  bool (*holds)(const Quantity& quantity, double value);
  /// Keys of the root table.
  void (*read_root)(const settings::Table& root, DeviceMap& map);
  const char* write_key;  ///< that makes a quantity writable
};

[[nodiscard]] const MapFormat& modbus_format();
[[nodiscard]] const MapFormat& text_format();

inline constexpr settings::Limits kAnyNumber{-1e9, 1e9};

/// "HOST:PORT" under `tcp` of a section [link], or "HOST" where there is a usual port.
[[nodiscard]] TcpAddress read_host_port(const settings::Table& link, std::optional<int> usual_port = {});

/// `device_key` and 'baud' of a section [link]: one of `bauds`, 9600 where none is given.
[[nodiscard]] SerialAddress read_serial_line(const settings::Table& link, std::string_view device_key,
                                             const std::vector<int>& bauds);

/// 'min', 'max' and whether they are in order.
void read_write_limits(const settings::Table& table, Quantity& quantity);

}  // namespace soak::hal
