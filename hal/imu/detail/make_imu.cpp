// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "hal/imu/detail/ahrs400_protocol.h"
#include "hal/imu/detail/stream_imu.h"
#include "hal/imu/detail/vectornav_protocol.h"
#include "hal/imu/detail/xsens_protocol.h"
#include "hal/imu/imu.h"
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

}  // namespace

std::unique_ptr<Imu> make_imu(const UnitLink& link) {
  return std::make_unique<imu::StreamImu>(imu::make_source(link.address), make_protocol(link));
}

}  // namespace soak::hal
