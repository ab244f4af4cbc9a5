// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "hal/devices/devices.h"
#include "hal/imu/detail/ahrs400_protocol.h"
#include "hal/imu/detail/stream_imu.h"
#include "hal/imu/detail/vectornav_protocol.h"
#include "hal/imu/detail/xsens_protocol.h"
#include "hal/links/detail/byte_source.h"

namespace soak::hal {
namespace {

std::unique_ptr<imu::Protocol> make_protocol(const UnitLink& link) {
  switch (link.decoder) {
    case UnitDecoder::ahrs400:
      return std::make_unique<imu::Ahrs400Protocol>(link.ranges);
    case UnitDecoder::vectornav:
      return std::make_unique<imu::VectorNavProtocol>();
    case UnitDecoder::xsens:
      break;
  }
  return std::make_unique<imu::XsensProtocol>();
}

struct AddressText {
  std::string operator()(const TcpAddress& tcp) const { return fmt::format("tcp {}:{}", tcp.host, tcp.port); }
  std::string operator()(const SerialAddress& serial) const { return fmt::format("serial {}", serial.device); }
  std::string operator()(const UsbAddress& usb) const {
    std::string text = fmt::format("usb {:04x}:{:04x}", usb.vendor, usb.product);
    for (const std::string& part : {usb.serial, usb.path}) text += part.empty() ? "" : " " + part;
    return text;
  }
  std::string operator()(const RecordedAddress& recorded) const { return fmt::format("recording {}", recorded.file); }
};

struct SourceOf {
  auto operator()(const TcpAddress& address) const { return imu::make_tcp_source(address); }
  auto operator()(const SerialAddress& address) const { return imu::make_serial_source(address); }
  auto operator()(const UsbAddress& address) const { return imu::make_usb_source(address); }
  auto operator()(const RecordedAddress& address) const { return imu::make_recorded_source(address); }
};

}  // namespace

std::string text_of(const UnitAddress& address) { return std::visit(AddressText{}, address); }

std::unique_ptr<Imu> make_imu(const UnitLink& link) {
  return std::make_unique<imu::StreamImu>(imu::make_source(link.address), make_protocol(link));
}

namespace imu {

std::unique_ptr<ByteSource> make_source(const UnitAddress& address) { return std::visit(SourceOf{}, address); }

}  // namespace imu
}  // namespace soak::hal
