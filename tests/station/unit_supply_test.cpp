// SPDX-License-Identifier: Apache-2.0
#include "station/lab/device_monitors.h"
#include "tests/errors.h"
#include "tests/station/fake_power.h"

#include <gtest/gtest.h>

namespace soak::station {
namespace {

class UnitSupplyTest : public ::testing::Test {
 protected:
  /// Output 1 after it was switched on at its limit of 0.5 A.
  void switch_on() {
    ASSERT_TRUE(supply.read({1}, 0.0));
    ASSERT_TRUE(supply.switch_on(1, {12.0, 0.5}, 10.0, 20.0));
  }

  FakePower power;
  /// The host's clock never is the slower one.
  UnitSupply supply{power, 5.0, 1e15};
};

TEST_F(UnitSupplyTest, NobodyKnowsForHowLongAnOutputWasOffBeforeItIsAsked) {
  EXPECT_EQ(supply.off_for_s(1, 1000.0), std::nullopt);
  EXPECT_FALSE(supply.switch_on(1, {}, 10.0, 1000.0));
  ASSERT_TRUE(supply.read({1}, 1000.0));
  EXPECT_EQ(supply.off_for_s(1, 1000.0), 0.0) << "somebody may just have switched it off";
  EXPECT_FALSE(supply.switch_on(1, {}, 10.0, 1009.0));
  EXPECT_FALSE(power.outputs[1].on);
  EXPECT_TRUE(supply.switch_on(1, {}, 10.0, 1010.0));
  EXPECT_TRUE(power.outputs[1].on);
}

TEST_F(UnitSupplyTest, AnOutputIsOffSinceItWentOffWhoeverSwitchesItOffAgain) {
  power.outputs[1].on = true;
  ASSERT_TRUE(supply.read({1}, 0.0));
  EXPECT_EQ(supply.off_for_s(1, 5.0), std::nullopt);
  ASSERT_TRUE(supply.switch_off(1, 10.0));
  ASSERT_TRUE(supply.switch_off(1, 14.0));
  ASSERT_TRUE(supply.read({1}, 15.0));
  EXPECT_EQ(supply.off_for_s(1, 15.0), 5.0);
  EXPECT_EQ(supply.off_for_s(2, 15.0), std::nullopt) << "another output";
}

TEST_F(UnitSupplyTest, AProcessClockThatWasBehindDoesNotShortenTheTimeOff) {
  UnitSupply real(power, 5.0, 1.0);
  ASSERT_TRUE(real.switch_off(1, 0.0));
  EXPECT_LT(real.off_for_s(1, 1e6), 1e6);
  EXPECT_FALSE(real.switch_on(1, {}, 1e6, 1e6));
}

TEST_F(UnitSupplyTest, AnOutputThatSomebodySwitchedOnIsNotOff) {
  ASSERT_TRUE(supply.switch_off(1, 0.0));
  power.outputs[1].on = true;
  ASSERT_TRUE(supply.read({1}, 100.0));
  EXPECT_EQ(supply.off_for_s(1, 100.0), std::nullopt);
  power.outputs[1].on = false;
  ASSERT_TRUE(supply.read({1}, 105.0));
  EXPECT_EQ(supply.off_for_s(1, 106.0), 1.0);
}

TEST_F(UnitSupplyTest, AnOutputThatCouldNotBeSwitchedOffDoesNotCountAsOff) {
  power.outputs[1].on = true;
  power.answers = false;
  EXPECT_FALSE(supply.switch_off(1, 0.0));
  EXPECT_EQ(supply.off_for_s(1, 100.0), std::nullopt);
}

TEST_F(UnitSupplyTest, TellsAnOutputThatIsOffOnlyWhereItWasSwitchedOn) {
  ASSERT_TRUE(supply.read({1}, 0.0));
  EXPECT_EQ(supply.fault_of(1), std::nullopt);
  switch_on();
  ASSERT_TRUE(supply.read({1}, 21.0));
  EXPECT_EQ(supply.fault_of(1), std::nullopt);
  power.outputs[1].on = false;
  ASSERT_TRUE(supply.read({1}, 22.0));
  const auto off = supply.fault_of(1);
  ASSERT_TRUE(off);
  EXPECT_TRUE(base::mentions(*off, {"output 1", "fake"}));
  power.outputs[1].tripped = true;
  ASSERT_TRUE(supply.read({1}, 23.0));
  ASSERT_TRUE(supply.fault_of(1));
  EXPECT_TRUE(base::mentions(*supply.fault_of(1), {"output 1", "fake"}));
  EXPECT_NE(supply.fault_of(1), off) << "a protection that tripped is told apart from a switch";
  ASSERT_TRUE(supply.switch_off(1, 24.0));
  EXPECT_EQ(supply.fault_of(1), std::nullopt) << "it is off because it shall be";
}

TEST_F(UnitSupplyTest, OneReadingAtTheCurrentLimitIsAnInrushTwoAreAFault) {
  switch_on();
  power.outputs[1].current_a = 0.499;
  ASSERT_TRUE(supply.read({1}, 21.0));
  EXPECT_EQ(supply.fault_of(1), std::nullopt);
  power.outputs[1].current_a = 0.3;
  ASSERT_TRUE(supply.read({1}, 22.0));
  power.outputs[1].current_a = 0.499;
  ASSERT_TRUE(supply.read({1}, 23.0));
  EXPECT_EQ(supply.fault_of(1), std::nullopt) << "not in a row";
  ASSERT_TRUE(supply.read({1}, 24.0));
  ASSERT_TRUE(supply.fault_of(1));
  EXPECT_TRUE(base::mentions(*supply.fault_of(1), {"output 1", "fake", "0.5 A"}));
}

TEST_F(UnitSupplyTest, WithoutAnAnswerNothingIsKnownAndNothingIsAFault) {
  switch_on();
  power.outputs[1].on = false;
  ASSERT_TRUE(supply.read({1}, 21.0));
  ASSERT_TRUE(supply.fault_of(1));
  power.answers = false;
  EXPECT_FALSE(supply.read({1}, 22.0));
  EXPECT_EQ(supply.reading(1), std::nullopt);
  EXPECT_EQ(supply.fault_of(1), std::nullopt);
  EXPECT_EQ(supply.trouble(), "no answer");
}

TEST_F(UnitSupplyTest, AsksAgainOnceItsTimeHasCome) {
  EXPECT_TRUE(supply.poll({1}, 0.0));
  EXPECT_FALSE(supply.poll({1}, 4.9));
  EXPECT_EQ(power.reads, 1);
  supply.forget();
  EXPECT_EQ(supply.reading(1), std::nullopt);
}

}  // namespace
}  // namespace soak::station
