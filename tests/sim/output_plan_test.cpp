// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/detail/xbus_device.h"

#include <gtest/gtest.h>

namespace soak::hal::sim {
namespace {

using base::Bytes;

// 100 Hz with temperature at 10 Hz; counter and time with every packet.
const Bytes kStation = {0x10, 0x20, 0xFF, 0xFF, 0x10, 0x60, 0xFF, 0xFF, 0x40, 0x20,
                        0x00, 0x64, 0x80, 0x20, 0x00, 0x64, 0x08, 0x10, 0x00, 0x0A};

TEST(OutputPlan, IsAsAsked) {
  const auto plan = OutputPlan::parse(kStation);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->data(), kStation);
}

TEST(OutputPlan, LeavesTheFactoryWithTheSame) { EXPECT_EQ(OutputPlan::factory().data(), kStation); }

TEST(OutputPlan, TellsTheRatesThatItReallyHas) {
  // 150 Hz asked of units that take 400/n: n = 2.67 becomes 3, 133 Hz.
  const auto plan = OutputPlan::parse(Bytes{0x40, 0x20, 0x00, 150});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->data(), (Bytes{0x40, 0x20, 0x00, 133}));
  EXPECT_DOUBLE_EQ(plan->items()[0].rate_hz(), 400.0 / 3.0);
  // More than there is.
  EXPECT_EQ(OutputPlan::parse(Bytes{0x80, 0x20, 0x07, 0xD0})->data(), (Bytes{0x80, 0x20, 0x01, 0x90}));
}

TEST(OutputPlan, RefusesWhatTheUnitsDoNotPutOut) {
  EXPECT_FALSE(OutputPlan::parse(Bytes{0x20, 0x10, 0x00, 0x64})) << "quaternions";
  EXPECT_FALSE(OutputPlan::parse(Bytes{0x40, 0x23, 0x00, 0x64})) << "double precision";
  EXPECT_FALSE(OutputPlan::parse(Bytes{0x40, 0x20, 0x00, 0x00})) << "no rate";
  EXPECT_FALSE(OutputPlan::parse(Bytes{0x40, 0x20, 0x00})) << "half an item";
}

TEST(OutputPlan, HasAPacketWheneverAnItemIsDue) {
  const auto plan = OutputPlan::parse(Bytes{0x40, 0x20, 0x00, 100, 0x08, 0x10, 0x00, 1});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->next_packet(0), 4);
  EXPECT_EQ(plan->next_packet(3), 4);
  EXPECT_EQ(plan->next_packet(4), 8);
  const OutputItem& temperature = plan->items()[1];
  EXPECT_TRUE(OutputPlan::due(temperature, 400));
  EXPECT_FALSE(OutputPlan::due(temperature, 396));
}

TEST(OutputPlan, HasNoPacketsWithoutARate) {
  EXPECT_FALSE(OutputPlan::parse(Bytes{0x10, 0x20, 0xFF, 0xFF})->next_packet(0));
  EXPECT_FALSE(OutputPlan().next_packet(0));
}

}  // namespace
}  // namespace soak::hal::sim
