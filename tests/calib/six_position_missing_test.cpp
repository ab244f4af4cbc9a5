// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "six_position_samples.h"

// Runs that lack some of the six positions: what is still right, what is absent, and the words for it.
namespace soak::calib {
namespace {

using test::Bench;
using test::kGravity_mps2;

Bench without(const std::vector<std::string>& faces) {
  Bench bench;
  std::erase_if(bench.stops, [&](const test::Stop& stop) {
    return std::find(faces.begin(), faces.end(), stop.face) != faces.end();
  });
  return bench;
}

std::string words(const SixPositionEstimate& e) { return test::texts(e.warnings, "missing_position"); }

class OneMissing : public ::testing::TestWithParam<std::string> {};

/// Of the axis that lost a position: bias of the accelerometer stays, its scale comes from one side; the gyro keeps
/// bias with g-sensitivity in it. The other axes lose nothing but the gyros' coupling to it.
TEST_P(OneMissing, CostsTheEvenOrderTermOfThatAxisAndItsGSensitivities) {
  const std::size_t axis = static_cast<std::size_t>(GetParam()[1] - 'X');
  const char letter = static_cast<char>(std::tolower(GetParam()[1]));
  const Bench bench = without({GetParam()});
  const auto e = test::estimate(bench);
  for (std::size_t a = 0; a < 3; ++a) {
    const SensorEstimate& accel = e.sensor[3 + a];
    EXPECT_EQ(accel.even_order.has_value(), a != axis);
    ASSERT_EQ(accel.plateaus.size(), 5U);
    for (const PlateauEstimate& p : accel.plateaus) {
      EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c), 1e-9);
      EXPECT_NEAR(*p.scale_ppm, bench.accel_scale_ppm(p.temp_c), 1e-4);
    }
    for (std::size_t j = 0; j < 3; ++j) {
      if (j == a) continue;
      EXPECT_NEAR(accel.coupling[j].value_or(1.0), bench.accel_coupling[j], 1e-9);
    }
    const SensorEstimate& gyro = e.sensor[a];
    ASSERT_EQ(gyro.plateaus.size(), 5U);
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(gyro.coupling[j].has_value(), a != axis && j != axis);
    if (a == axis) continue;
    for (const PlateauEstimate& p : gyro.plateaus) EXPECT_NEAR(p.bias, bench.gyro_bias(p.temp_c), 1e-9);
  }
  const std::string text = words(e);
  const std::string lost = "accel_" + std::string(1, letter) +
                           ": the positions do not determine its even-order term (which stays in the scale error; its "
                           "bias is that at 0 g) (missing: " +
                           GetParam() + ")\n";
  EXPECT_NE(text.find(lost), std::string::npos) << text;
  EXPECT_NE(text.find("gyro_" + std::string(1, letter) +
                      ": the positions do not determine its g-sensitivity (which stays in the bias, with the Earth's "
                      "rotation) (missing: " +
                      GetParam() + ")\n"),
            std::string::npos)
      << text;
  // The two other gyros, and no word of the two other accelerometers.
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4) << text;
}

INSTANTIATE_TEST_SUITE_P(SixPosition, OneMissing, ::testing::Values("+X", "-X", "+Y", "-Y", "+Z", "-Z"),
                         [](const auto& info) {
                           return std::string(info.param[0] == '+' ? "Plus" : "Minus") + info.param[1];
                         });

TEST(SixPositionMissing, TheEvenOrderTermThenStaysWhereTheWordsSay) {
  Bench bench = without({"-Y"});
  bench.even_order = 3e-5;
  const auto e = test::estimate(bench);
  for (const PlateauEstimate& p : e.sensor[4].plateaus) {
    EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c), 1e-9);
    EXPECT_NEAR(*p.scale_ppm, bench.accel_scale_ppm(p.temp_c) + 1e6 * 3e-5 * kGravity_mps2, 1e-4);
  }
}

TEST(SixPositionMissing, APairCostsTheScaleErrorOfThatAxisAndTheMisalignmentsAlongIt) {
  const Bench bench = without({"+Y", "-Y"});
  const auto e = test::estimate(bench);
  const SensorEstimate& accel_y = e.sensor[4];
  for (const PlateauEstimate& p : accel_y.plateaus) {
    EXPECT_FALSE(p.scale_ppm);
    EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c), 1e-9);
  }
  EXPECT_FALSE(accel_y.even_order);
  EXPECT_FALSE(e.sensor[3].coupling[1]);
  EXPECT_TRUE(e.sensor[3].even_order);
  EXPECT_NEAR(e.sensor[3].plateaus[0].bias, bench.accel_bias(-20.0), 1e-9);
  const std::string text = words(e);
  EXPECT_NE(
      text.find("accel_y: the positions do not determine its scale error; its even-order term (missing: +Y, -Y)\n"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find("accel_x: the positions do not determine its misalignment along y (missing: +Y, -Y)\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("gyro_x: the positions do not determine its g-sensitivity along y (missing: +Y, -Y)\n"),
            std::string::npos)
      << text;
}

TEST(SixPositionMissing, TwoPositionsLeaveTheirAxisBiasAndScale) {
  const Bench bench = without({"+Y", "-Y", "+Z", "-Z"});
  const auto e = test::estimate(bench);
  for (const PlateauEstimate& p : e.sensor[3].plateaus) {
    EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c), 1e-9);
    EXPECT_NEAR(*p.scale_ppm, bench.accel_scale_ppm(p.temp_c), 1e-4);
  }
  EXPECT_FALSE(e.sensor[3].even_order);
  EXPECT_NE(words(e).find("accel_x: the positions do not determine its even-order term; its misalignment along y; its "
                          "misalignment along z (missing: +Y, -Y, +Z, -Z)\n"),
            std::string::npos)
      << words(e);
}

TEST(SixPositionMissing, OneSideFaceDoesNotTellMisalignmentFromEvenOrder) {
  Bench bench = without({"-Y", "+Z", "-Z"});
  const auto e = test::estimate(bench);
  EXPECT_FALSE(e.sensor[3].even_order);
  EXPECT_NEAR(e.sensor[3].coupling[1].value_or(1.0), bench.accel_coupling[1], 1e-9);
  EXPECT_NE(words(e).find("accel_x: the positions do not determine its even-order term (which stays in the "
                          "misalignment); its misalignment along z (missing: -Y, +Z, -Z)\n"),
            std::string::npos)
      << words(e);
}

TEST(SixPositionMissing, OnePositionThroughoutLeavesTheScaleErrorInTheBias) {
  const Bench bench = without({"+X", "-X", "+Y", "-Y", "-Z"});
  const auto e = test::estimate(bench);
  for (const PlateauEstimate& p : e.sensor[5].plateaus) {
    EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c) + 1e-6 * bench.accel_scale_ppm(p.temp_c) * kGravity_mps2, 1e-9);
  }
  EXPECT_NE(words(e).find("accel_z: the positions do not determine its scale error (which stays in the bias)"),
            std::string::npos)
      << words(e);
}

TEST(SixPositionMissing, AVisitWithoutItsPairLeansOnTheOthers) {
  Bench bench;
  bench.even_order = 3e-5;
  auto segments = test::segments_of(bench);
  // −Z of the second visit, +Z and −Z of the third.
  std::erase_if(segments, [](const Segment& s) {
    return (s.key.visit == 1 && s.key.position == "-Z") || (s.key.visit == 2 && s.key.position.back() == 'Z');
  });
  const auto e = estimate_six_positions(segments, test::standard_site(), {});
  ASSERT_EQ(e.sensor[5].plateaus.size(), 5U);
  for (const PlateauEstimate& p : e.sensor[5].plateaus) {
    EXPECT_NEAR(p.bias, bench.accel_bias(p.temp_c) + 3e-5 * kGravity_mps2 * kGravity_mps2, 1e-9);
    EXPECT_EQ(p.scale_ppm.has_value(), p.visit != 2);
  }
  EXPECT_EQ(words(e), "accel_z: the positions do not determine its scale error at 1 of 5 plateau visits (0 °C)\n");
}

}  // namespace
}  // namespace soak::calib
