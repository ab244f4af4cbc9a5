// SPDX-License-Identifier: Apache-2.0
#include "hal/imu/detail/xsens_frames.h"

#include <cstring>
#include <vector>

#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

/// Numbers that are none are equal here: the bytes count.
bool same(const hal::imu::MtData2& a, const hal::imu::MtData2& b) {
  const auto same_bytes = [](const auto& x, const auto& y) {
    return x.has_value() == y.has_value() && (!x || std::memcmp(&*x, &*y, sizeof *x) == 0);
  };
  return a.packet_counter == b.packet_counter && a.sample_time_fine == b.sample_time_fine && a.status == b.status &&
         same_bytes(a.accel_mps2, b.accel_mps2) && same_bytes(a.rate_rps, b.rate_rps) && same_bytes(a.temp_c, b.temp_c);
}

}  // namespace

bool mt_data2(Input input) {
  const auto packet = hal::imu::decode_mt_data2(input);
  if (!packet) return false;
  // An element that is not known changes nothing, wherever it stands.
  std::vector<std::uint8_t> longer(input.begin(), input.end());
  for (const int byte : {0x20, 0x10, 0x02, 0xAB, 0xCD}) longer.push_back(static_cast<std::uint8_t>(byte));
  const auto again = hal::imu::decode_mt_data2(longer);
  require(again && same(*packet, *again), "unknown elements are passed over");
  longer.pop_back();
  require(!hal::imu::decode_mt_data2(longer), "an element that goes past the end is refused");
  return true;
}

}  // namespace soak::fuzz
