// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "base/bytes.h"
#include "hal/imu/detail/xsens_frames.h"
#include "tests/fuzz/stream_promises.h"

namespace soak::fuzz {

bool xbus(Input input) {
  const auto describe = [](const hal::imu::XbusMessage& message) {
    require(message.data.size() <= hal::imu::kMaxXbusData, "no message is longer than the protocol allows");
    return std::pair(static_cast<int>(message.id), base::Bytes(message.data.begin(), message.data.end()));
  };
  const auto size = [](const hal::imu::XbusMessage& message) { return message.frame_size; };
  return check_stream<hal::imu::XbusDecoder>(input, 8192, describe, size) > 0;
}

}  // namespace soak::fuzz
