// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/link_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "hal/maps/detail/address_reader.h"

namespace soak::hal {
namespace {

constexpr int kModbusPort = 502;

ModbusRtu read_rtu(const SettingsTable& link) {
  constexpr Limits any_baud{1, 1e9};
  // libmodbus takes any other for 9600.
  const std::vector<int> bauds = {1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200};
  ModbusRtu address;
  address.device = link.text("rtu");
  if (address.device.empty()) link.refuse("rtu", "'link.rtu' must name a serial device");
  address.baud = link.whole("baud", any_baud, address.baud);
  if (std::find(bauds.begin(), bauds.end(), address.baud) == bauds.end()) {
    link.refuse("baud", fmt::format("'link.baud' must be one of {}", fmt::join(bauds, ", ")));
  }
  address.parity = link.choice<char>("parity", {{"N", 'N'}, {"E", 'E'}, {"O", 'O'}}, 'N');
  address.stop_bits = link.whole("stop_bits", {1, 2}, 1);
  return address;
}

}  // namespace

ModbusLinkSettings read_link(const SettingsTable& link) {
  constexpr Limits unit_limits{0, 255};
  constexpr int last_unit = 247;
  constexpr int direct_unit = 255;
  ModbusLinkSettings settings;
  const bool rtu = link.has("rtu");
  if (rtu == link.has("tcp")) link.refuse("", "'link' needs either 'tcp' or 'rtu'");
  if (rtu) settings.address = read_rtu(link);
  if (link.has("tcp")) {
    const TcpAddress tcp = read_host_port(link, "tcp", kModbusPort);
    settings.address = ModbusTcp{tcp.host, tcp.port};
  }
  settings.unit = link.whole("unit", unit_limits, settings.unit);
  const bool reserved = settings.unit > last_unit && settings.unit != direct_unit;
  if (reserved || (rtu && (settings.unit == 0 || settings.unit == direct_unit))) {
    link.refuse("unit", fmt::format("'link.unit' must be from 1 to {}{}", last_unit, rtu ? "" : ", or 0 or 255"));
  }
  settings.response_timeout_s = link.number("response_timeout_s", {0.05, 30.0}, settings.response_timeout_s);
  settings.gap_s = link.optional_number("gap_s", {0.0, 0.5});
  if (settings.gap_s.value_or(0.0) > settings.response_timeout_s) {
    link.refuse("gap_s", "'link.gap_s' must not be longer than 'response_timeout_s'");
  }
  settings.max_block = link.whole("max_block", {2, 125}, settings.max_block);
  settings.poll_s = link.number("poll_s", {0.1, 60.0}, settings.poll_s);
  return settings;
}

}  // namespace soak::hal
