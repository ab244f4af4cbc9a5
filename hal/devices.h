// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "base/result.h"
#include "hal/chamber.h"
#include "hal/fixture.h"
#include "hal/imu.h"
#include "hal/register_map.h"
#include "hal/unit_power.h"

/// Makes the devices that a station's configuration names. Nothing is opened yet.
namespace soak::hal {

/// Refuses (bad_input) a map that lacks a quantity which every chamber needs.
[[nodiscard]] base::Result<std::unique_ptr<Chamber>> make_modbus_chamber(const RegisterMap& map);
[[nodiscard]] base::Result<std::unique_ptr<Fixture>> make_modbus_fixture(const RegisterMap& map);
[[nodiscard]] base::Result<std::unique_ptr<UnitPower>> make_modbus_power(const RegisterMap& map);

/// Where a unit's bytes come from.
struct TcpAddress {
  std::string host;
  int port = 0;
};
struct SerialAddress {
  std::string device;  ///< also a pseudo-terminal
  int baud = 115200;
};

/// A unit of the Xsens MTi family: Xbus protocol, MTData2 packets.
[[nodiscard]] std::unique_ptr<Imu> make_xsens_imu(const std::variant<TcpAddress, SerialAddress>& address);

}  // namespace soak::hal
