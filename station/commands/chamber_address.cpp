// SPDX-License-Identifier: Apache-2.0
#include "station/commands/chamber_address.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <variant>

#include "base/text.h"

namespace soak::station {
namespace {

constexpr int kModbusPort = 502;
constexpr int kUsualBaud = 9600;

base::Result<hal::TcpAddress> parse_address(const std::string& text, std::optional<int> usual_port) {
  const std::size_t colon = text.rfind(':');
  hal::TcpAddress address{text.substr(0, colon), usual_port.value_or(0)};
  if (colon != std::string::npos) {
    const auto port = base::parse_int(text.substr(colon + 1));
    address.port = port && *port >= 1 && *port <= 65535 ? static_cast<int>(*port) : 0;
  }
  if (!address.host.empty() && address.port != 0) return address;
  return base::bad_input(fmt::format("'{}' is not HOST:PORT", text), "--tcp");
}

base::Status set_tcp(const std::string& text, hal::DeviceMap& map) {
  const auto* stated = std::get_if<hal::TcpAddress>(&map.link.address);
  std::optional<int> usual_port = stated ? std::optional(stated->port) : std::nullopt;
  if (map.protocol == hal::MapProtocol::modbus) usual_port = kModbusPort;
  const auto address = parse_address(text, usual_port);
  if (!address) return base::forward_error(address);
  map.link.address = *address;
  return {};
}

void set_serial(const ChamberProbeCommand& command, hal::DeviceMap& map) {
  const auto* stated = std::get_if<hal::SerialAddress>(&map.link.address);
  hal::SerialAddress line = stated ? *stated : hal::SerialAddress{.device = "", .baud = kUsualBaud};
  line.device = command.serial;
  if (command.baud != 0) line.baud = command.baud;
  map.link.address = line;
}

}  // namespace

base::Status set_address(const ChamberProbeCommand& command, hal::DeviceMap& map) {
  if (!command.tcp.empty() && !command.serial.empty()) {
    return base::bad_input("an address is either --tcp or --serial", "--serial");
  }
  if (command.baud != 0 && command.serial.empty()) {
    return base::bad_input("it belongs to --serial", "--baud");
  }
  if (command.unit >= 0) {
    if (map.protocol == hal::MapProtocol::text) {
      return base::bad_input("this controller speaks text: there are no unit numbers", "--unit");
    }
    map.link.unit = command.unit;
  }
  if (!command.serial.empty()) set_serial(command, map);
  return command.tcp.empty() ? base::Status{} : set_tcp(command.tcp, map);
}

std::string address_text(const hal::DeviceMap& map) {
  if (const auto* tcp = std::get_if<hal::TcpAddress>(&map.link.address)) {
    return fmt::format("tcp {}:{}", tcp->host, tcp->port);
  }
  const auto& line = std::get<hal::SerialAddress>(map.link.address);
  return fmt::format("serial {} at {} baud, 8{}{}", line.device, line.baud, line.parity, line.stop_bits);
}

}  // namespace soak::station
