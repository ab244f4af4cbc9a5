// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "base/bytes.h"
#include "calib/curve/calibration.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::samples {

/// A calibration's file as firmware holds it: the bytes, and what the runtime has read of them.
struct Loaded {
  explicit Loaded(const Calibration& calibration) : bytes(*encode(calibration)) {
    EXPECT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  }
  base::Bytes bytes;
  soak_cal cal{};
};

}  // namespace soak::calib::samples
