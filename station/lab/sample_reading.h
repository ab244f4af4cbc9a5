// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "hal/imu/imu.h"

namespace soak::station {

/// What sensor number `sensor` (calib::index_of) reads in the sample: rad/s or m/s².
inline double reading_of(const hal::ImuSample& sample, std::size_t sensor) {
  return sensor < 3 ? static_cast<double>(sample.rate_rps[sensor]) : static_cast<double>(sample.accel_mps2[sensor - 3]);
}

}  // namespace soak::station
