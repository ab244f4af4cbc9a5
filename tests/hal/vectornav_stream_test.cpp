// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/errors.h"
#include "tests/hal/unit_benches.h"

namespace soak::hal::imu::test {
namespace {

class VectorNavStream : public InStream<VectorNavBench> {};

TEST(VectorNavSetup, StopsTheLinesIdentifiesAndConfiguresTheUnit) {
  VectorNavBench bench;
  ASSERT_TRUE(bench.open());
  for (int i = 0; i < 20; ++i) {
    if (bench.unit.lines) bench.send(bench.unit.async_line());
    ASSERT_TRUE(bench.step());
  }
  EXPECT_EQ(bench.unit.heard,
            (std::vector<std::string>{"VNWRG,06,0", "VNRRG,01", "VNRRG,03", "VNRRG,04", "VNWRG,75,1,16,05,0001,0E10"}));
  EXPECT_EQ(*bench.imu->identity(), (ImuIdentity{"0100011981", "VN-100T-CR", "2.1.0.0", false}));
  EXPECT_EQ(bench.imu->state(), ImuState::streaming);
  EXPECT_EQ(bench.imu->statistics().restarts, 0U);
}

TEST(VectorNavSetup, FirmwareWithoutSaturationFlagsIsAskedWithoutThem) {
  VectorNavBench bench;
  bench.unit.knows_saturation = false;
  ASSERT_TRUE(bench.open());
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.unit.heard.back(), "VNWRG,75,1,16,05,0001,0610");
  bench.send(bench.unit.packets(3));
  ASSERT_TRUE(bench.step());
  EXPECT_EQ(bench.samples.size(), 3U);
}

TEST(VectorNavSetup, DividesTheRateOfTheModel) {
  VectorNavBench bench;
  bench.unit.model = "VN-200T-CR";
  ASSERT_TRUE(bench.open({.rate_hz = 100.0}));
  ASSERT_TRUE(bench.settle());
  EXPECT_EQ(bench.unit.divisor, 4);
}

TEST(VectorNavSetup, ARateThatTheModelDoesNotDivideIntoFailsAndNamesTheNearest) {
  VectorNavBench bench;
  ASSERT_TRUE(bench.open({.rate_hz = 300.0}));
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"266.7 Hz", "300 Hz"}));
}

TEST(VectorNavSetup, AnErrorOfTheUnitIsNamedWithTheRequest) {
  VectorNavBench bench;
  bench.unit.error_upon_output = 12;
  ASSERT_TRUE(bench.open());
  const auto status = bench.settle();
  ASSERT_FALSE(status);
  EXPECT_TRUE(names(status.error(), {"12", "register 75"}));
  EXPECT_EQ(bench.imu->state(), ImuState::failed);
}

TEST_F(VectorNavStream, PacketsBecomeSamples) {
  send_and_step(bench.unit.packets(25));
  ASSERT_EQ(bench.samples.size(), 25U);
  for (std::size_t i = 0; i < 25; ++i) {
    const auto number = static_cast<float>(i);
    EXPECT_DOUBLE_EQ(bench.samples[i].t_s, 1.0 + 0.02 * static_cast<double>(i + 1));
    EXPECT_EQ(bench.samples[i].accel_mps2, (std::array<float, 3>{number, -number, 9.8F}));
    EXPECT_EQ(bench.samples[i].rate_rps, (std::array<float, 3>{0.5F * number, 0.25F, -0.125F}));
    EXPECT_EQ(bench.samples[i].temp_c, i % 5 == 0 ? std::optional(20.0F + number) : std::nullopt) << i;
    EXPECT_FALSE(bench.samples[i].clipped);
  }
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 0U);
  EXPECT_EQ(bench.imu->statistics().lost_packets, 0U);
}

TEST_F(VectorNavStream, SaturatedAccelerometersAndGyrosAreClippedOtherSensorsAreNot) {
  for (const auto& [flags, clipped] : {std::pair{0x0008U, true}, {0x0100U, true}, {0x0207U, false}}) {
    bench.unit.saturation = flags;
    send_and_step(bench.unit.packet());
    EXPECT_EQ(bench.samples.back().clipped, clipped) << flags;
    EXPECT_EQ(bench.samples.back().status, flags);
  }
}

TEST_F(VectorNavStream, GarbageBetweenPacketsIsCountedAndCostsNoSample) {
  for (int i = 0; i < 50; ++i) send_and_step(hex("01 FA 24 FA 05 01") + bench.unit.packet());
  send_and_step(Bytes(300, 0));
  EXPECT_EQ(bench.samples.size(), 50U);
  EXPECT_EQ(bench.imu->statistics().garbage_bytes, 50U * 6U + 300U);
}

TEST_F(VectorNavStream, AnotherOutputWithTheSameQuantitiesIsPassedOver) {
  send_and_step(golden_vectornav() + bench.unit.packet());
  EXPECT_EQ(bench.samples.size(), 1U);
}

TEST_F(VectorNavStream, ALineThatWasTurnedOffProvesARestart) {
  send_and_step(bench.unit.packets(50));
  bench.unit.restart();
  send_and_step(bench.unit.async_line());
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(2));
  EXPECT_EQ(bench.samples.size(), 52U);
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_LT(bench.samples.back().t_s, 1.0);
  EXPECT_EQ(bench.imu->statistics().restarts, 1U);
}

TEST_F(VectorNavStream, TimeThatBeginsAnewIsARestart) {
  send_and_step(bench.unit.packets(50));
  bench.unit.time_ns = 0;
  send_and_step(bench.unit.packets(1));
  ASSERT_TRUE(bench.settle());
  send_and_step(bench.unit.packets(1));
  EXPECT_EQ(bench.samples.back().power_on, 1U);
  EXPECT_EQ(bench.imu->statistics().restarts, 1U);
}

}  // namespace
}  // namespace soak::hal::imu::test
