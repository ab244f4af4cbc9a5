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

base::Status set_tcp(const std::string& text, hal::RegisterMap& map) {
  const auto address = parse_address(text, kModbusPort);
  if (!address) return base::forward_error(address);
  map.link.address = hal::ModbusTcp{address->host, address->port};
  return {};
}

base::Status set_tcp(const std::string& text, hal::TextMap& map) {
  const auto* stated = std::get_if<hal::TcpAddress>(&map.link.address);
  const auto address = parse_address(text, stated ? std::optional(stated->port) : std::nullopt);
  if (!address) return base::forward_error(address);
  map.link.address = *address;
  return {};
}

void set_serial(const ChamberProbeCommand& command, hal::RegisterMap& map) {
  const auto* stated = std::get_if<hal::ModbusRtu>(&map.link.address);
  hal::ModbusRtu line = stated ? *stated : hal::ModbusRtu{.device = "", .baud = kUsualBaud};
  line.device = command.serial;
  if (command.baud != 0) line.baud = command.baud;
  map.link.address = line;
}

void set_serial(const ChamberProbeCommand& command, hal::TextMap& map) {
  const auto* stated = std::get_if<hal::SerialAddress>(&map.link.address);
  const int usual = stated ? stated->baud : kUsualBaud;
  map.link.address = hal::SerialAddress{command.serial, command.baud != 0 ? command.baud : usual};
}

std::string text_of(const hal::ModbusTcp& address) { return fmt::format("tcp {}:{}", address.host, address.port); }
std::string text_of(const hal::TcpAddress& address) { return fmt::format("tcp {}:{}", address.host, address.port); }
std::string text_of(const hal::ModbusRtu& line) {
  return fmt::format("serial {} at {} baud, 8{}{}", line.device, line.baud, line.parity, line.stop_bits);
}
std::string text_of(const hal::SerialAddress& line) {
  return fmt::format("serial {} at {} baud, 8N1", line.device, line.baud);
}

}  // namespace

base::Status set_address(const ChamberProbeCommand& command, hal::ChamberMap& map) {
  if (!command.tcp.empty() && !command.serial.empty()) {
    return base::bad_input("an address is either --tcp or --serial", "--serial");
  }
  if (command.baud != 0 && command.serial.empty()) {
    return base::bad_input("it belongs to --serial", "--baud");
  }
  if (command.unit >= 0) {
    auto* registers = std::get_if<hal::RegisterMap>(&map);
    if (!registers) return base::bad_input("this controller speaks text: there are no unit numbers", "--unit");
    registers->link.unit = command.unit;
  }
  if (!command.serial.empty()) std::visit([&command](auto& one) { set_serial(command, one); }, map);
  if (command.tcp.empty()) return {};
  return std::visit([&command](auto& one) { return set_tcp(command.tcp, one); }, map);
}

std::string address_text(const hal::ChamberMap& map) {
  return std::visit(
      [](const auto& one) {
        return std::visit([](const auto& address) { return text_of(address); }, one.link.address);
      },
      map);
}

}  // namespace soak::station
