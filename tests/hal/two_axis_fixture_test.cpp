// SPDX-License-Identifier: Apache-2.0
// The two-axis fixture against pymodbus: what is written when, and what its answers are taken for.
#include <gtest/gtest.h>

#include "hal/devices/fixture.h"
#include "modbus_peer.h"
#include "tests/errors.h"

namespace soak::hal {
namespace {

/// A controller that is at once where it is told to be; `more` comes after and so wins.
std::vector<std::string> registers(const std::vector<std::string>& more = {}) {
  std::vector<std::string> specs = {"f32hi:0:0",  "f32hi:2:0",  "f32hi:4:0", "u16:6:0",      "f32hi:10:0",
                                    "f32hi:12:0", "f32hi:14:0", "u16:16:0",  "u16:32:0x5441"};
  specs.insert(specs.end(), more.begin(), more.end());
  return specs;
}

const std::vector<std::string> kObeys = {"copy:0:10", "copy:1:11", "copy:2:12", "copy:3:13", "copy:4:14", "copy:5:15"};

// High words of IEEE 754 numbers whose low word is 0.
constexpr const char* kNinety = "17076";               // 42B4
constexpr const char* kMinusSixty = "49776 (-15760)";  // C270
constexpr const char* kSixty = "17008";                // 4270

std::unique_ptr<Fixture> fixture_at(int port) {
  auto fixture = make_fixture(test::repository_map("fixtures/two-axis.toml", port));
  EXPECT_TRUE(fixture) << fixture.error().message;
  return *std::move(fixture);
}

TEST(TwoAxisFixture, WritesBothAnglesThenStartsAndKnowsThePositionByItsAngles) {
  SOAK_START_PYMODBUS(server, "tcp", registers(kObeys));
  const auto fixture = fixture_at(server->port());
  EXPECT_EQ(fixture->read()->position, "+Z");
  ASSERT_TRUE(fixture->move_to("-X"));
  EXPECT_EQ(server->writes(), 3);
  EXPECT_EQ(test::mbpoll_read(server->port(), 0, "4"), kNinety);
  EXPECT_EQ(test::mbpoll_read(server->port(), 2, "4"), "49844 (-15692)") << "-90";
  EXPECT_EQ(test::mbpoll_read(server->port(), 6, "4"), "1");
  const auto reading = fixture->read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(reading->position, "-X");
  EXPECT_FALSE(reading->moving);
}

TEST(TwoAxisFixture, IsInNoPositionWhileItMovesOrStandsBeyondTheTolerance) {
  SOAK_START_PYMODBUS(server, "tcp", registers({"f32hi:10:89.8", "f32hi:12:90"}));
  const auto fixture = fixture_at(server->port());
  EXPECT_EQ(fixture->read()->position, std::nullopt);
  EXPECT_EQ(fixture->read()->angles, "outer 89.80°, inner 90.00°, 0.00 °/s");
  ASSERT_TRUE(test::mbpoll_write(server->port(), 11, "4", "0"));
  ASSERT_TRUE(test::mbpoll_write(server->port(), 10, "4", kNinety));
  EXPECT_EQ(fixture->read()->position, "+X");
  ASSERT_TRUE(test::mbpoll_write(server->port(), 16, "4", "1"));
  EXPECT_EQ(fixture->read()->position, std::nullopt);
  EXPECT_TRUE(fixture->read()->moving);
}

TEST(TwoAxisFixture, ReportsFaultsAndAnglesThatAreNoNumbersAsDeviceErrors) {
  SOAK_START_PYMODBUS(server, "tcp", registers());
  const auto fixture = fixture_at(server->port());
  for (const auto& [address, value] : {std::pair{16, "2"}, std::pair{16, "7"}, std::pair{10, "32704"}}) {  // 7FC0: NaN
    ASSERT_TRUE(test::mbpoll_write(server->port(), 16, "4", "0"));
    ASSERT_TRUE(test::mbpoll_write(server->port(), address, "4", value));
    const auto reading = fixture->read();
    ASSERT_FALSE(reading) << address << " " << value;
    EXPECT_EQ(reading.error().kind, base::ErrorKind::device);
  }
}

TEST(TwoAxisFixture, NeverTurnsOneThatIsWoundUpBeyondItsCables) {
  SOAK_START_PYMODBUS(server, "tcp", registers({"f32hi:10:360"}));
  const auto fixture = fixture_at(server->port());
  const auto refused = fixture->move_to("+Z");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::device);
  EXPECT_TRUE(names(refused.error(), {"outer", "360.00", "185"}));
  EXPECT_FALSE(fixture->read());
  EXPECT_EQ(server->writes(), 0);
}

TEST(TwoAxisFixture, SpinsCounterClockwiseSeenFromAboveWhicheverEndOfTheAxisIsUp) {
  SOAK_START_PYMODBUS(server, "tcp", registers(kObeys));
  const auto fixture = fixture_at(server->port());
  ASSERT_TRUE(fixture->spin("+Z", 60.0));
  EXPECT_EQ(test::mbpoll_read(server->port(), 4, "4"), kSixty);
  EXPECT_EQ(test::mbpoll_read(server->port(), 6, "4"), "2");
  auto reading = fixture->read();
  ASSERT_TRUE(reading);
  EXPECT_TRUE(reading->moving);
  EXPECT_EQ(reading->position, std::nullopt) << "the angle only passes by";
  EXPECT_EQ(reading->rate_dps, 60.0);

  const auto still_turns = fixture->move_to("-Z");
  ASSERT_FALSE(still_turns);
  EXPECT_EQ(still_turns.error().kind, base::ErrorKind::device);
  EXPECT_EQ(fixture->read()->rate_dps, 0.0) << "it was halted";
  ASSERT_TRUE(fixture->move_to("-Z"));
  ASSERT_TRUE(fixture->spin("-Z", 60.0));
  EXPECT_EQ(test::mbpoll_read(server->port(), 4, "4"), kMinusSixty);
  reading = fixture->read();
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->rate_dps, 60.0);
  ASSERT_TRUE(fixture->halt());
  EXPECT_EQ(fixture->read()->position, "-Z");
}

TEST(TwoAxisFixture, RefusesToSpinWhereItsAxisIsNotVerticalOrItStandsElsewhere) {
  SOAK_START_PYMODBUS(server, "tcp", registers({"f32hi:10:90", "f32hi:12:90"}));
  const auto fixture = fixture_at(server->port());
  for (const auto& [label, rate_dps] : {std::pair{"+X", 60.0}, std::pair{"+Z", 201.0}, std::pair{"+W", 60.0}}) {
    const auto refused = fixture->can_spin(label, rate_dps);
    ASSERT_FALSE(refused) << label;
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  }
  EXPECT_TRUE(fixture->can_spin("-Z", -200.0));
  const auto elsewhere = fixture->spin("+Z", 60.0);
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().kind, base::ErrorKind::device);
  ASSERT_TRUE(fixture->halt());
  EXPECT_EQ(server->writes(), 0) << "what does not turn is not told to halt";
}

TEST(TwoAxisFixture, APositionerWithCodesCannotSpin) {
  const auto fixture = make_fixture(test::repository_map("fixtures/modbus-positioner.toml", 1));
  ASSERT_TRUE(fixture);
  const auto refused = (*fixture)->spin("+Z", 60.0);
  EXPECT_TRUE(is_bad_input(refused));
  EXPECT_TRUE((*fixture)->halt());
}

}  // namespace
}  // namespace soak::hal
