// SPDX-License-Identifier: Apache-2.0
// Maps of fixtures that are told angles: what a sound one says, and how each mistake is told.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "hal/maps/detail/fixture_axes.h"
#include "hal/maps/device_map.h"
#include "tests/errors.h"
#include "tests/hal/map_samples.h"

namespace soak::hal {
namespace {

std::string shipped() {
  const auto file = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures/fixtures/two-axis.toml";
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The shipped map with one passage replaced.
std::string with(const std::string& passage, const std::string& other) {
  std::string text = shipped();
  const auto at = text.find(passage);
  EXPECT_NE(at, std::string::npos) << passage;
  return text.replace(at, passage.size(), other);
}

using test::refusal;

void expect_refused(const std::string& text, std::initializer_list<std::string_view> named) {
  EXPECT_TRUE(base::mentions(refusal(text), named));
}

// The rotations were done by hand: a tilt about x by 90 degrees brings y up, then a turn by 90 degrees about the
// table's own axis brings x there. Headings are those of the axis after the vertical one.
TEST(TwoAxisMap, TellsPositionsHeadingsAndSensesOfTheShippedOne) {
  const auto map = parse_device_map(shipped(), "two-axis.toml");
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_TRUE(map->axes);
  EXPECT_EQ(map->axes->tolerance_deg, 0.1);
  EXPECT_EQ(map->axes->spins, FixtureAxis::inner);
  const std::map<std::string, double> headings_deg = {{"+X", 180}, {"-X", 0}, {"+Y", 90},
                                                      {"-Y", 90},  {"+Z", 0}, {"-Z", 0}};
  ASSERT_EQ(map->positions.size(), 6U);
  ASSERT_EQ(map->azimuths_deg.size(), 6U);
  ASSERT_EQ(map->axes->angles_deg.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string& label = map->positions[i];
    EXPECT_NEAR(std::remainder(map->azimuths_deg[i] - headings_deg.at(label), 360.0), 0.0, 1e-9) << label;
    EXPECT_EQ(map->axes->spin_sign[i], label == "+Z" ? 1 : label == "-Z" ? -1 : 0) << label;
  }
}

// A turntable that carries a tilting axis reaches four positions and can spin in all of them.
TEST(TwoAxisMap, KnowsATableWhoseOuterAxisIsVertical) {
  const AxisDirections table{{0, 0, 1}, {0, 0, 1}, {1, 0, 0}};
  const auto up = up_at(table, {123.0, 90.0});
  EXPECT_NEAR(up[1], 1.0, 1e-12) << "+Y";
  EXPECT_NEAR(up_at(table, {-50.0, 180.0})[2], -1.0, 1e-12) << "-Z";
  for (const double tilt_deg : {0.0, 90.0, 180.0, -90.0}) {
    EXPECT_EQ(sense_about_up(table, FixtureAxis::outer, {70.0, tilt_deg}), 1);
    EXPECT_EQ(sense_about_up(table, FixtureAxis::inner, {70.0, tilt_deg}), 0);
  }
  const AxisDirections hanging{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
  EXPECT_EQ(sense_about_up(hanging, FixtureAxis::outer, {0.0, 0.0}), -1);
  EXPECT_NEAR(heading_deg(table, {30.0, 0.0}), -30.0, 1e-9) << "counter-clockwise is to the west of north";
  EXPECT_NEAR(heading_deg(hanging, {30.0, 0.0}), 30.0, 1e-9);
}

// Turning the fixture about a vector keeps every angle between directions, and what pointed up stays a unit vector.
TEST(TwoAxisMap, TurnsAreRotations) {
  const AxisDirections axes{{0, 0, 1}, {1, 0, 0}, {0, 0, 1}};
  for (double outer_deg = -180.0; outer_deg <= 180.0; outer_deg += 37.0) {
    for (double inner_deg = -180.0; inner_deg <= 180.0; inner_deg += 41.0) {
      const auto up = up_at(axes, {outer_deg, inner_deg});
      EXPECT_NEAR(dot(up, up), 1.0, 1e-12);
      // The inner axis is fixed in the fixture: its angle to the vertical is the tilt.
      EXPECT_NEAR(dot(up, axes.inner), std::cos(outer_deg * 3.14159265358979323846 / 180.0), 1e-12);
    }
  }
}

TEST(TwoAxisMap, RefusesAnglesOfAnotherPosition) {
  expect_refused(with("\"+X\" = [90, 90]", "\"+X\" = [90, 0]"), {"[90, 0]", "+Y", "+X"});
  expect_refused(with("\"+X\" = [90, 90]", "\"+X\" = [90, 45]"), {"[90, 45]", "(0.707, 0.707, 0.000)", "+X"});
  EXPECT_EQ(refusal(with("\"+X\" = [90, 90]", "\"+X\" = [90.5, 89.5]")), "") << "levelled angles of a real fixture";
  // The axis lies otherwise than the map says: every position but those on it is told.
  expect_refused(with("outer = \"+X\"", "outer = \"-X\""), {"4 "});
}

TEST(TwoAxisMap, RefusesAnglesThatTheCablesDoNotBear) {
  expect_refused(with("max = 185", "max = 170"), {"'-Z'", "180", "'outer_request'", "-5", "170"});
  expect_refused(with("max = 185\n", ""), {"[quantity.outer_request]", "'min'", "'max'"});
}

TEST(TwoAxisMap, RefusesWhatItLacksOrWhatBelongsElsewhere) {
  expect_refused(with("[quantity.inner_position]", "[quantity.position]"), {"[quantity.inner_position]"});
  expect_refused(with("moving = 1, ", ""), {"[quantity.status]", "'moving'"});
  expect_refused(with("kind = \"fixture\"", "kind = \"fixture\"\npositions = [\"+X\"]"), {"'positions'", "[axes]"});
  expect_refused(with("spins = \"inner\"", "#"), {"'axes.rate_tolerance_dps'", "'spins'"});
  expect_refused(with("spins = \"inner\"", "#"), {"[quantity.rate_request]", "'axes.spins'"});
  expect_refused(with("\"+X\" = [90, 90]", "\"+W\" = [90, 90]"), {"'+W'", "+X, -X"});
  expect_refused(with("\"+X\" = [90, 90]", "\"+X\" = [90]"), {"'+X'", "[outer, inner]"});
  expect_refused(with("up = \"+Z\"", "up = \"z\""), {"'axes.up'", "\"+X\""});
  expect_refused(with("kind = \"fixture\"", "kind = \"power\""), {"'axes'"});
}

}  // namespace
}  // namespace soak::hal
