// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <tuple>

#include "base/bytes.h"
#include "hal/imu/detail/vectornav_frame.h"
#include "tests/fuzz/stream_promises.h"

namespace soak::fuzz {

bool vectornav(Input input) {
  const auto describe = [](const hal::imu::VectorNavMessage& message) {
    if (!message.is_text) {
      const auto packet = hal::imu::decode_vectornav(message);
      require(packet.fields == message.fields, "a packet names its fields");
    }
    return std::tuple(std::string(message.text), message.fields.common, message.fields.imu,
                      base::Bytes(message.data.begin(), message.data.end()));
  };
  const auto size = [](const hal::imu::VectorNavMessage& message) { return message.frame_size; };
  return check_stream<hal::imu::VectorNavDecoder>(input, 512, describe, size) > 0;
}

}  // namespace soak::fuzz
