// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "hal/imu/detail/ahrs400_protocol.h"
#include "hal/imu/detail/vectornav_protocol.h"
#include "hal/imu/detail/xsens_protocol.h"
#include "tests/hal/ahrs400_peer.h"
#include "tests/hal/unit_bench.h"
#include "tests/hal/vectornav_peer.h"
#include "tests/hal/xsens_peer.h"

/// A driver and a scripted unit for each protocol. What differs stands in the same words in each of them, for the tests
/// that every protocol must pass (unit_protocols_test.cpp).
namespace soak::hal::imu::test {

struct XsensBench : UnitBench<ScriptedUnit> {
  static constexpr double kStep_s = 0.01;  ///< from packet to packet
  static constexpr auto kFirstRequest = "(30)";
  static constexpr std::size_t kRequests = 4;  ///< that are sent before it counts as failed
  static constexpr double kImpossibleRates_hz[] = {0.0, 0.5, 100.5, 2001.0, -1.0};

  XsensBench() : UnitBench(std::make_unique<XsensProtocol>(), {}) {}
  [[nodiscard]] bool streams() const { return unit.measuring; }
  void pause_unit(double seconds) { unit.ticks += static_cast<std::uint32_t>(seconds * 10'000.0); }
  /// Returns its serial number.
  std::string exchange_unit() {
    unit.serial = 0x12345678;
    return "12345678";
  }
};

struct VectorNavBench : UnitBench<VectorNavUnit> {
  static constexpr double kStep_s = 0.02;
  static constexpr auto kFirstRequest = "(register 6)";
  static constexpr std::size_t kRequests = 4;
  static constexpr double kImpossibleRates_hz[] = {0.0, 0.5, 801.0, -1.0};

  VectorNavBench() : UnitBench(std::make_unique<VectorNavProtocol>(), {.rate_hz = 50.0, .temp_rate_hz = 10.0}) {}
  [[nodiscard]] bool streams() const { return unit.divisor != 0; }
  void pause_unit(double seconds) { unit.time_ns += static_cast<std::uint64_t>(seconds * 1e9); }
  std::string exchange_unit() { return unit.serial = "0100000001"; }
};

struct AhrsBench : UnitBench<Ahrs400Unit> {
  static constexpr double kStep_s = 0.0155;
  static constexpr auto kFirstRequest = "(R)";
  static constexpr std::size_t kRequests = 3;  ///< the first of four attempts listens for a stream
  static constexpr double kImpossibleRates_hz[] = {0.0, 71.0, 100.0};

  AhrsBench()
      : UnitBench(std::make_unique<Ahrs400Protocol>(Ahrs400Ranges{100.0, 2.0}),
                  {.rate_hz = 60.0, .temp_rate_hz = 10.0}) {}
  [[nodiscard]] bool streams() const { return unit.continuous; }
  void pause_unit(double seconds) { unit.time_s += seconds; }
  std::string exchange_unit() {
    unit.serial = 1234;
    return "1234";
  }
};

/// Driver and unit in the middle of a stream: what went before is over, and forgotten.
template <class Bench>
class InStream : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(bench.open());
    ASSERT_TRUE(bench.settle());
    ASSERT_EQ(bench.imu->state(), ImuState::streaming);
    bench.unit.heard.clear();
  }

  void send_and_step(const Bytes& bytes) {
    bench.send(bytes);
    ASSERT_TRUE(bench.step());
  }

  Bench bench;
};

}  // namespace soak::hal::imu::test
