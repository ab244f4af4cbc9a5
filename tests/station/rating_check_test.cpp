// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure.h"

#include <gtest/gtest.h>

namespace soak::station {
namespace {

Procedure rated_soak(double coldest_c, double warmest_c) {
  Procedure p;
  p.file = "p.toml";
  p.set_points_c = {20.0, coldest_c, warmest_c};
  p.overshoot_c = 2.0;
  return p;
}

calib::UnitType rated(std::string name, double min_c, double max_c) {
  calib::UnitType type;
  type.name = std::move(name);
  type.temp_min_c = min_c;
  type.temp_max_c = max_c;
  return type;
}

TEST(RatingCheck, OvershootCountsAtBothEnds) {
  const std::vector<calib::UnitType> types = {rated("a", -40.0, 85.0)};
  EXPECT_TRUE(check_ratings(rated_soak(-38.0, 83.0), types, {}, {}));
  EXPECT_FALSE(check_ratings(rated_soak(-38.1, 83.0), types, {}, {}));
  EXPECT_FALSE(check_ratings(rated_soak(-38.0, 83.1), types, {}, {}));
}

TEST(RatingCheck, EveryTypeThatCannotBearItIsNamedWithRatingAndSetPoint) {
  const std::vector<calib::UnitType> types = {rated("good", -40.0, 85.0), rated("cold", -40.0, 60.0),
                                              rated("warm", 0.0, 85.0)};
  const auto status = check_ratings(rated_soak(-30.0, 70.0), types, {}, {});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(status.error().where, "p.toml");
  const std::string& message = status.error().message;
  EXPECT_EQ(message.find("'good'"), std::string::npos);
  for (const char* part : {"'cold'", "-40 to 60 °C", "set point 70 °C", "'warm'", "0 to 85 °C", "set point -30 °C"}) {
    EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
  }
}

TEST(RatingCheck, OfATextNamesTheLineOfTheSetPoints) {
  const std::string head =
      "name=\"n\"\npurpose=\"diagnosis\"\nkind=\"soak\"\npositions.order=[\"+X\"]\n[temperatures]\n";
  const std::vector<calib::UnitType> types = {rated("a", -40.0, 85.0)};
  EXPECT_TRUE(parse_procedure(head + "overshoot_c=2\nlist_c=[83]\n", "p.toml", types));
  EXPECT_EQ(parse_procedure(head + "overshoot_c=2\nlist_c=[84]\n", "p.toml", types).error().where, "p.toml:7");
  EXPECT_EQ(parse_procedure(head + "start_c=0\nstop_c=84\nstep_c=84\nsweep=\"up\"\n", "p.toml", types).error().where,
            "p.toml:5");
}

TEST(RatingCheck, ATypeWithoutARatingIsRefused) {
  calib::UnitType unknown;
  EXPECT_FALSE(check_ratings(rated_soak(20.0, 21.0), {unknown}, {}, {}));
  unknown.temp_min_c = -100.0;
  EXPECT_FALSE(check_ratings(rated_soak(20.0, 21.0), {unknown}, {}, {}));
}

TEST(RatingCheck, TheTemperatureThatARunEndsAtCounts) {
  Procedure p = rated_soak(-5.0, 10.0);
  EXPECT_FALSE(check_ratings(p, {rated("cold only", -40.0, 26.0)}, {}, {}));  // ends at 25 °C
  EXPECT_TRUE(check_ratings(p, {rated("cold only", -40.0, 27.0)}, {}, {}));
}

TEST(RatingCheck, TheChamberTakesItsLimitsAsSetPoints) {
  EXPECT_TRUE(check_ratings(rated_soak(-30.0, 70.0), {}, -30.0, 70.0));
  EXPECT_FALSE(check_ratings(rated_soak(-30.0, 70.0), {}, -29.0, {}));
  EXPECT_FALSE(check_ratings(rated_soak(-30.0, 70.0), {}, {}, 69.0));
  EXPECT_TRUE(check_ratings(rated_soak(-30.0, 70.0), {}, {}, {}));
}

}  // namespace
}  // namespace soak::station
