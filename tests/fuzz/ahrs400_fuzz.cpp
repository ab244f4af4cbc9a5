// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/ahrs400_decoder.h"

#include <algorithm>
#include <cmath>

#include "tests/fuzz/targets.h"

namespace soak::fuzz {

/// A packet at the end of a piece is believed before the byte behind it is known: splits may differ by packets that
/// garbage follows, and are not compared.
bool ahrs400(Input input) {
  std::size_t framed = 0;
  std::size_t packets = 0;
  hal::imu::Ahrs400Decoder decoder;
  const std::size_t piece = input.empty() ? 1 : 1 + input[0] % 61;
  for (std::size_t at = 0; at < input.size(); at += piece) {
    decoder.append(input.subspan(at, std::min(piece, input.size() - at)));
    while (const auto packet = decoder.next()) {
      framed += hal::imu::kAhrs400PacketSize;
      ++packets;
      require(std::isfinite(hal::imu::ahrs400_temp_c(packet->temp)), "a temperature is a number");
    }
    require(decoder.pending_bytes() < 2 * hal::imu::kAhrs400PacketSize, "the memory is bounded");
  }
  require(framed + decoder.garbage_bytes() + decoder.pending_bytes() == input.size(), "every byte is accounted for");
  while (decoder.drop_partial()) {
  }
  require(decoder.pending_bytes() == 0, "what does not end can be given up");
  return packets > 0;
}

}  // namespace soak::fuzz
