// SPDX-License-Identifier: Apache-2.0
#include "calib/plan/sensor_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/errors.h"

namespace soak::calib {
namespace {

using Generator = std::mt19937_64;
using Truth = std::function<double(double)>;

/// A stationary curve of many cosines, whose frequencies are drawn from the spectrum of a Matérn process of order 5/2:
/// Student's t with five degrees of freedom, over the length.
Truth drawn_curve(double scale, double length_c, Generator& generator) {
  constexpr int kCosines = 400;
  std::student_t_distribution<double> spectrum(5.0);
  std::uniform_real_distribution<double> phase(0.0, 6.283185307179586);
  std::vector<std::pair<double, double>> cosines;
  for (int i = 0; i < kCosines; ++i) cosines.emplace_back(spectrum(generator) / length_c, phase(generator));
  return [=](double temp_c) {
    double sum = 0.0;
    for (const auto& [frequency, at] : cosines) sum += std::cos(frequency * temp_c + at);
    return scale * std::sqrt(2.0 / kCosines) * sum;
  };
}

/// A smooth curve, and one with a feature of a few degrees somewhere on it.
Truth featured_curve(double feature, Generator& generator) {
  const double centre_c = std::uniform_real_distribution<double>(-20.0, 60.0)(generator);
  return [=](double temp_c) {
    return 0.2 * std::atan((temp_c - 15.0) / 25.0) + feature * std::exp(-0.5 * std::pow((temp_c - centre_c) / 4.0, 2));
  };
}

struct Scatter {
  double run = 0.01;
  double visit = 0.0006;
  double noise = 0.0008;
  double half_gap = 0.003;
};

/// Four runs over every 5 °C from −30 to 70 °C and back.
StoredCurve stored(const Truth& truth, const Scatter& scatter, Generator& generator) {
  std::normal_distribution<double> normal;
  StoredCurve unit;
  unit.dwell_s = 300.0;
  for (int run = 0; run < 4; ++run) {
    unit.data.runs.push_back("R" + std::to_string(run + 1));
    const double offset = scatter.run * normal(generator);
    for (int visit = 0; visit < 41; ++visit) {
      const bool up = visit <= 20;
      const double temp_c = -30.0 + 5.0 * (up ? visit : 40 - visit) + 0.1 * normal(generator);
      const double value = truth(temp_c) + offset + (up ? 1.0 : -1.0) * scatter.half_gap +
                           scatter.visit * normal(generator) + scatter.noise * normal(generator);
      unit.data.rows.push_back({run, run, up ? Sweep::up : Sweep::down, 100.0 * visit, temp_c, value, scatter.noise});
    }
  }
  unit.data.branches = unit.data.runs;
  return unit;
}

std::vector<StoredCurve> fleet(int units, const std::function<Truth(Generator&)>& draw, std::uint64_t seed) {
  Generator generator(seed);
  std::vector<StoredCurve> list;
  for (int i = 0; i < units; ++i) list.push_back(stored(draw(generator), {}, generator));
  return list;
}

// Published values of the two correlations at one length: (1 + √3) e^−√3 and (1 + √5 + 5/3) e^−√5.
TEST(SensorPicture, CorrelationsAreThoseOfMaternsClass) {
  SensorPicture picture;
  picture.length_c = 12.0;
  EXPECT_DOUBLE_EQ(correlation(picture, 0.0), 1.0);
  EXPECT_NEAR(correlation(picture, -12.0), 0.5239941088318203, 1e-15);
  picture.smoothness = Smoothness::once;
  EXPECT_NEAR(correlation(picture, 12.0), 0.4833577245965077, 1e-15);
}

TEST(SensorPicture, LearnsWhatUnitsWereDrawnFrom) {
  const auto units = fleet(8, [](Generator& g) { return drawn_curve(0.1, 20.0, g); }, 5);
  const auto learnt = learn_picture(units);
  ASSERT_TRUE(learnt);
  const SensorPicture& picture = learnt->picture;
  EXPECT_EQ(learnt->units, 8);
  EXPECT_TRUE(learnt->half_gap_known && learnt->run_to_run_known);
  // Scale and length of a process over five lengths are known to some tens of percent, together better.
  EXPECT_GT(picture.scale, 0.1 / 1.6);
  EXPECT_LT(picture.scale, 0.1 * 1.6);
  EXPECT_GT(picture.length_c, 20.0 / 1.5);
  EXPECT_LT(picture.length_c, 20.0 * 1.5);
  EXPECT_EQ(picture.smoothness, Smoothness::twice);
  // 24 offsets about their means, 160 differences, 1312 rows.
  EXPECT_NEAR(picture.run_to_run, 0.01, 0.004);
  EXPECT_NEAR(picture.half_gap, 0.003, 0.0003);
  EXPECT_NEAR(picture.visit, 0.0006, 0.0003);
  EXPECT_NEAR(picture.noise, 0.0008, 1e-12);
  EXPECT_DOUBLE_EQ(picture.dwell_s, 300.0);
}

// A gap of ten times the scatter of power-ons.
TEST(SensorPicture, HysteresisDoesNotHideTheScatterOfPowerOns) {
  Generator generator(9);
  std::vector<StoredCurve> units;
  for (int i = 0; i < 8; ++i) units.push_back(stored(featured_curve(0.0, generator), {.half_gap = 0.1}, generator));
  const auto learnt = learn_picture(units);
  ASSERT_TRUE(learnt);
  EXPECT_NEAR(learnt->picture.half_gap, 0.1, 0.001);
  EXPECT_NEAR(learnt->picture.run_to_run, 0.01, 0.004);  // 24 offsets about their means
  EXPECT_NEAR(learnt->picture.visit, 0.0006, 0.0003);
}

// Power cycles at the beginning of each pass, as planned campaigns have them: each gives its own level and nothing
// else.
TEST(SensorPicture, PowerOnsAtOnePlateauShowTheirScatterAlone) {
  Generator generator(10);
  std::normal_distribution<double> normal;
  auto unit = stored(featured_curve(0.0, generator), {.half_gap = 0.005}, generator);
  const auto before = learn_picture(std::vector{unit});
  for (int run = 4; run < 40; ++run) {
    unit.data.runs.push_back("C" + std::to_string(run));
    const double value = -0.2 + 0.01 * normal(generator);
    unit.data.rows.push_back({run, run, Sweep::down, 0.0, 20.0, value, 0.0008});
  }
  unit.data.branches = unit.data.runs;
  const auto after = learn_picture(std::vector{unit});
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->picture.half_gap, before->picture.half_gap, 0.0002);
  EXPECT_NEAR(after->picture.visit, before->picture.visit, 0.0002);
  EXPECT_GT(after->picture.run_to_run, 0.005);
}

TEST(SensorPicture, LocalFeaturesMakeItExpectMoreOnTheWayFromPlateauToPlateau) {
  const auto smooth = learn_picture(fleet(4, [](Generator& g) { return featured_curve(0.0, g); }, 6));
  const auto featured = learn_picture(fleet(4, [](Generator& g) { return featured_curve(0.05, g); }, 6));
  ASSERT_TRUE(smooth && featured);
  const auto change_over_5_c = [](const SensorPicture& p) {
    return p.scale * std::sqrt(2.0 * (1.0 - correlation(p, 5.0)));
  };
  EXPECT_LT(featured->picture.length_c, smooth->picture.length_c);
  EXPECT_GT(change_over_5_c(featured->picture), 1.2 * change_over_5_c(smooth->picture));
}

TEST(SensorPicture, SaysWhatTheUnitsDoNotShow) {
  auto units = fleet(1, [](Generator& g) { return featured_curve(0.0, g); }, 7);
  std::erase_if(units.front().data.rows, [](const CurveRow& row) { return row.run > 0 || row.sweep == Sweep::down; });
  const auto learnt = learn_picture(units);
  ASSERT_TRUE(learnt);
  EXPECT_FALSE(learnt->half_gap_known);
  EXPECT_FALSE(learnt->run_to_run_known);
}

TEST(SensorPicture, ReadingsThatDoNotMoveHaveAFlatCurve) {
  Generator generator(12);
  const Scatter none{0.0, 0.0, 0.0, 0.0};
  const std::vector<StoredCurve> units = {stored([](double) { return 0.25; }, none, generator)};
  const auto learnt = learn_picture(units);
  ASSERT_TRUE(learnt) << learnt.error().message;
  EXPECT_GT(learnt->picture.scale, 0.0);
  EXPECT_LT(learnt->picture.scale, 1e-6);
}

TEST(SensorPicture, RefusesUnitsWithoutPlateaus) {
  EXPECT_FALSE(learn_picture({}));
  auto units = fleet(1, [](Generator& g) { return featured_curve(0.0, g); }, 8);
  units.front().data.by_plateau = false;
  const auto learnt = learn_picture(units);
  ASSERT_FALSE(learnt);
  EXPECT_EQ(learnt.error().kind, base::ErrorKind::bad_input);
}

}  // namespace
}  // namespace soak::calib
