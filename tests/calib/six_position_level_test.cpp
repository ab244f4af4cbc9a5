// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calib/estimate/six_position.h"
#include "calib/estimate/unit_rows.h"
#include "calib/model/model_document.h"
#include "six_position_level_samples.h"
#include "six_position_samples.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

using test::Place;

TEST(SixPositionLevel, SixHeadingsSeparateLevelErrorFromMisalignmentAndEvenOrder) {
  Place place = test::six_headings();
  place.north_rad = 2e-3;
  place.east_rad = -1.5e-3;
  const auto e = test::estimate(place);
  ASSERT_TRUE(e.level_error) << e.no_level_error;
  EXPECT_NEAR(e.level_error->north.value, 2e-3, 1e-9);
  EXPECT_NEAR(e.level_error->east.value, -1.5e-3, 1e-9);
  EXPECT_EQ(e.no_level_error, "");
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorEstimate& accel = e.sensor[i + 3];
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(*accel.coupling[j], i == j ? 0.0 : test::kPlaceMisalignment[j], 1e-8);
    }
    EXPECT_NEAR(accel.even_order->value, test::kPlaceEvenOrder, 1e-9);
    EXPECT_NEAR(*accel.plateaus[1].scale_ppm, 1e6 * test::kPlaceScale, 1e-3);
    // The bias at ±g; K₂ g² beside that at 0 g.
    EXPECT_NEAR(accel.plateaus[1].bias, 0.05 + test::kPlaceEvenOrder * std::pow(test::kPlaceGravity_mps2, 2), 1e-7);
  }
  EXPECT_TRUE(e.warnings.empty());
}

TEST(SixPositionLevel, WholeRotationOfTheEarthLeavesGSensitivityAlone) {
  for (const double latitude_deg : {51.0, -33.5}) {
    Place place = test::six_headings();
    place.latitude_deg = latitude_deg;
    const auto e = test::estimate(place);
    for (std::size_t i = 0; i < 3; ++i) {
      // The rotation of the Earth is worth 5e-6 here.
      for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(*e.sensor[i].coupling[j], test::kPlaceGSensitivity[j], 1e-12);
      for (const PlateauEstimate& plateau : e.sensor[i].plateaus) EXPECT_NEAR(plateau.bias, 0.01, 1e-12);
    }
  }
}

TEST(SixPositionLevel, EqualHeadingsHideTheTiltAcrossThem) {
  Place place = test::six_headings();
  for (auto& [face, azimuth_deg] : place.stops) azimuth_deg = 0.0;
  place.site_azimuth_deg = 0.0;
  place.east_rad = 2e-3;
  const auto e = test::estimate(place);
  EXPECT_FALSE(e.level_error);
  EXPECT_NE(e.no_level_error.find("do not separate a tilt towards 90°"), std::string::npos) << e.no_level_error;
  // What cannot be told stays where it was without headings.
  Site blind = test::site_of(place);
  blind.azimuth_deg.reset();
  const auto without = estimate_six_positions(test::segments_of(place), blind, {});
  for (std::size_t s = 3; s < 6; ++s) {
    EXPECT_EQ(e.sensor[s].coupling, without.sensor[s].coupling);
    EXPECT_EQ(e.sensor[s].plateaus[0].bias, without.sensor[s].plateaus[0].bias);
  }
}

TEST(SixPositionLevel, AFaceAtSeveralHeadingsTellsItsOwnTiltFromTheLevel) {
  Place place = test::every_quarter();
  place.north_rad = -1e-3;
  place.east_rad = 5e-4;
  base::Random random(4);
  for (const std::string_view face : kSixPositionLabels) {
    for (double& tilt : place.face_tilt_rad[std::string(face)]) tilt = 1e-3 * random.gaussian();
  }
  const auto e = test::estimate(place);
  ASSERT_TRUE(e.level_error) << e.no_level_error;
  EXPECT_NEAR(e.level_error->north.value, -1e-3, 1e-7);
  EXPECT_NEAR(e.level_error->east.value, 5e-4, 1e-7);
  EXPECT_LT(e.level_error->per_face_tilt[0], 1e-6);
}

TEST(SixPositionLevel, TiltedFacesReachItAsFarAsStated) {
  constexpr double kFace_rad = 1e-4;
  base::Random random(5);
  std::array<double, 2> squares{};
  std::array<double, 2> stated{};
  double misalignment = 0.0;
  constexpr int kDraws = 150;
  for (int i = 0; i < kDraws; ++i) {
    Place place = test::six_headings();
    place.accel_noise = 1e-6;
    for (const std::string_view face : kSixPositionLabels) {
      for (double& tilt : place.face_tilt_rad[std::string(face)]) tilt = kFace_rad * random.gaussian();
    }
    const auto e = test::estimate(place);
    ASSERT_TRUE(e.level_error);
    squares[0] += std::pow(e.level_error->north.value / kFace_rad, 2) / kDraws;
    squares[1] += std::pow(e.level_error->east.value / kFace_rad, 2) / kDraws;
    stated = e.level_error->per_face_tilt;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double error = *e.sensor[i + 3].coupling[j] - test::kPlaceMisalignment[j];
      misalignment += std::pow(error / kFace_rad, 2) / (3.0 * kDraws);
    }
  }
  // Root mean squares of 150 draws are known to 6 %; three of those.
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(std::sqrt(squares[k]) / stated[k], 1.0, 0.18) << stated[k];
  EXPECT_LT(std::sqrt(misalignment), std::hypot(std::sqrt(0.5), std::max(stated[0], stated[1])));
}

TEST(SixPositionLevel, StandardErrorsAreHonest) {
  double level = 0.0;
  double misalignment = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Place place = test::six_headings();
    place.north_rad = 1e-3;
    place.accel_noise = 3e-3;
    place.gyro_noise = 1e-5;
    place.seed = seed;
    const auto e = test::estimate(place);
    ASSERT_TRUE(e.level_error);
    level += std::pow((e.level_error->north.value - 1e-3) / e.level_error->north.standard_error, 2) / 2.0;
    level += std::pow(e.level_error->east.value / e.level_error->east.standard_error, 2) / 2.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const SensorEstimate& accel = e.sensor[i + 3];
      misalignment += std::pow((*accel.coupling[j] - test::kPlaceMisalignment[j]) / accel.coupling_se[j], 2) / 3.0;
    }
    ++count;
  }
  // 120 and 180 estimates: root mean squares are known to 6 %.
  EXPECT_NEAR(std::sqrt(level / count), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(misalignment / count), 1.0, 0.2);
}

void expect_same_bits(const SixPositionEstimate& a, const SixPositionEstimate& b) {
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    EXPECT_EQ(a.sensor[s].coupling, b.sensor[s].coupling);
    EXPECT_EQ(a.sensor[s].coupling_se, b.sensor[s].coupling_se);
    ASSERT_EQ(a.sensor[s].plateaus.size(), b.sensor[s].plateaus.size());
    for (std::size_t p = 0; p < a.sensor[s].plateaus.size(); ++p) {
      EXPECT_EQ(a.sensor[s].plateaus[p].bias, b.sensor[s].plateaus[p].bias);
      EXPECT_EQ(a.sensor[s].plateaus[p].bias_se, b.sensor[s].plateaus[p].bias_se);
      EXPECT_EQ(a.sensor[s].plateaus[p].scale_ppm, b.sensor[s].plateaus[p].scale_ppm);
    }
  }
}

TEST(SixPositionLevel, WhereOneHeadingIsMissingNoneIsUsedAndItSaysSo) {
  Place place = test::six_headings();
  place.east_rad = 1e-3;
  place.accel_noise = 3e-3;
  place.gyro_noise = 1e-5;
  auto blind = test::segments_of(place);
  for (Segment& segment : blind) segment.position->azimuth_deg.reset();
  const auto without = estimate_six_positions(blind, test::site_of(place), {});
  EXPECT_NE(without.no_level_error, "");
  EXPECT_EQ(test::texts(without.warnings, "heading_incomplete"), "");

  auto segments = test::segments_of(place);
  segments[2].position->azimuth_deg.reset();
  const auto partly = estimate_six_positions(segments, test::site_of(place), {});
  expect_same_bits(partly, without);
  EXPECT_TRUE(base::mentions(test::texts(partly.warnings, "heading_incomplete"), {"'+Y 30"}));

  Site nowhere = test::site_of(place);
  nowhere.azimuth_deg.reset();
  const auto unknown = estimate_six_positions(test::segments_of(place), nowhere, {});
  expect_same_bits(unknown, without);
  EXPECT_NE(test::texts(unknown.warnings, "heading_incomplete"), "");
  EXPECT_NE(unknown.no_level_error, without.no_level_error);
  EXPECT_NE(unknown.no_level_error, partly.no_level_error);
}

TEST(SixPositionLevel, AWrongAzimuthIsNotTakenForADegreeOfTilt) {
  Place place = test::six_headings();
  place.north_rad = 0.06;
  const auto e = test::estimate(place);
  EXPECT_FALSE(e.level_error);
  EXPECT_NE(e.no_level_error.find("check the azimuths"), std::string::npos) << e.no_level_error;
}

UnitInput unit_at(Place place, std::vector<ReferenceUse> references) {
  UnitInput input{.unit = "U", .references = std::move(references)};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    place.seed = seed;
    input.runs.push_back({.run_id = std::to_string(seed),
                          .label = "R" + std::to_string(seed),
                          .campaign = "c",
                          .site = test::site_of(place),
                          .segments = test::segments_of(place)});
  }
  return input;
}

ReferenceUse squareness(double u_rad) {
  ReferenceUse use;
  use.reference.kind = ReferenceKind::fixture_squareness;
  use.reference.standard_uncertainty = u_rad;
  return use;
}

TEST(SixPositionLevel, AUnitStatesItWithWhatTheFacesAdd) {
  Place place = test::six_headings();
  place.north_rad = 1e-3;
  place.accel_noise = 1e-3;
  place.gyro_noise = 1e-6;
  const auto rows = make_rows(unit_at(place, {squareness(2e-4)}));
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_TRUE(rows->level.to_north_east) << rows->level.reason;
  const StatedValue& north = (*rows->level.to_north_east)[0];
  EXPECT_NEAR(north.value, 1e-3, 4.0 * north.standard_error);
  EXPECT_NEAR(*north.type_b, 2e-4 * rows->level.per_face_tilt[0], 1e-15);
  EXPECT_GT(north.ci95, 1.9 * *north.type_b);
  const double worse = std::max(rows->level.per_face_tilt[0], rows->level.per_face_tilt[1]);
  EXPECT_NEAR(*(*rows->accel_misalignment)[0][1].type_b, 2e-4 * std::hypot(std::sqrt(0.5), worse), 1e-12);
  EXPECT_EQ(rows->earth_removed, EarthRemoval::whole);
  for (std::size_t i = 0; i < 3; ++i) {
    // What is left of the Earth's rotation is its part by 0.2 mrad, not the 5e-6 of the whole.
    const StatedValue& entry = (*rows->g_sensitivity)[i][(i + 1) % 3];
    EXPECT_NEAR(*entry.type_b, 7.292115e-5 * 2e-4 / std::sqrt(2.0) / test::kPlaceGravity_mps2, 1e-13);
    EXPECT_NEAR(entry.value, test::kPlaceGSensitivity[(i + 1) % 3], entry.ci95 + 2e-8);
  }
}

TEST(SixPositionLevel, WithoutHeadingsADocumentSaysWhatIsMissing) {
  Place place = test::six_headings();
  place.accel_noise = 1e-3;
  place.gyro_noise = 1e-6;
  UnitInput input = unit_at(place, {});
  for (RunInput& run : input.runs) {
    for (Segment& segment : run.segments) segment.position->azimuth_deg.reset();
  }
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows) << rows.error().message;
  const auto document = fit_json(make_model(*rows, {}));
  EXPECT_EQ(document["earth_rate_subtracted"], "vertical");
  EXPECT_TRUE(document["level_error"]["north_rad"].is_null());
  EXPECT_TRUE(document["level_error"]["east_rad"].is_null());
  EXPECT_NE(document["level_error"]["reason"], "");
}

TEST(SixPositionLevel, TheRotationOfTheEarthCountsOnceInAGyrosFixtureLine) {
  // Gyros without g-sensitivity: what is estimated across their axes is the rotation of the Earth alone.
  const auto fixture_of = [](Place place) {
    place.gyro_noise = 1e-7;
    place.accel_noise = 1e-3;
    UnitInput input = unit_at(place, {squareness(2e-4)});
    for (RunInput& run : input.runs) {
      for (Segment& segment : run.segments) {
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = 0; j < 3; ++j) {
            segment.sensor[i].mean -= test::kPlaceGSensitivity[j] * test::kPlaceGravity_mps2 * segment.position->up[j];
          }
        }
        segment.position->azimuth_deg.reset();
      }
    }
    const auto rows = make_rows(input);
    return rows->bias_type_b[0][2].constant;
  };
  Place place = test::six_headings();
  // Opposite headings of opposite faces: the estimate holds the horizontal rotation in full.
  place.stops = {{"+X", 0.0}, {"-X", 0.0}, {"+Y", 0.0}, {"-Y", 180.0}, {"+Z", 90.0}, {"-Z", 270.0}};
  const double horizontal = 7.292115e-5 * std::cos(51.0 * base::kRadPerDeg);
  EXPECT_NEAR(fixture_of(place) / (horizontal * 2e-4 / std::sqrt(2.0)), 1.0, 0.02);
}

}  // namespace
}  // namespace soak::calib
