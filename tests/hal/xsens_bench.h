// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "hal/imu/detail/xsens_protocol.h"
#include "tests/hal/unit_bench.h"
#include "tests/hal/xsens_peer.h"

namespace soak::hal::imu::test {

struct Bench : UnitBench<ScriptedUnit> {
  Bench() : UnitBench(std::make_unique<XsensProtocol>()) {}
};

}  // namespace soak::hal::imu::test
