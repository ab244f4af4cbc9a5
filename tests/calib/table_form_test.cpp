// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/table_form.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

constexpr int kDense = 40000;

const TableCurve& bias_table(const Calibration& calibration) {
  return std::get<TableCurve>(calibration.sensors.front().bias);
}

/// Largest difference on a grid that is 150 times as dense as the densest table.
double sampled_difference(const Curve& a, const Curve& b, double min_c, double max_c) {
  double largest = 0.0;
  for (int i = 0; i <= kDense; ++i) {
    const double temp_c = min_c + (max_c - min_c) * i / kDense;
    largest = std::max(largest, std::abs(evaluate(a, temp_c) - evaluate(b, temp_c)));
  }
  return largest;
}

anfis::Model random_model(base::Random& random, anfis::Shape shape, double least_slope) {
  std::vector<anfis::CurveRule> rules;
  for (int k = 0; k < 6; ++k) {
    const double slope = shape == anfis::Shape::bell ? random.uniform(least_slope, least_slope + 3.0) : 0.0;
    rules.push_back({random.uniform(0.2, 0.4), slope, -1.0 + 0.4 * k + random.uniform(-0.1, 0.1),
                     random.uniform(-2.0, 2.0), random.uniform(-1.0, 1.0)});
  }
  return fis_of(shape, rules, {20.0, 50.0}, {0.01, 0.004});
}

TEST(TableForm, BoundHoldsEverywhereAndExceedsTheDifferenceByLittle) {
  base::Random random(21);
  for (int i = 0; i < 12; ++i) {
    const auto shape = i % 2 == 0 ? anfis::Shape::bell : anfis::Shape::gaussian;
    const Curve curve = random_model(random, shape, 1.0);
    for (const int points : {2, 17, 256}) {
      const auto result = table_form(with_bias(curve), points);
      ASSERT_TRUE(result) << result.error().message;
      const double bound = *bias_table(*result).bound;
      const double sampled = sampled_difference(result->sensors[0].bias, curve, -30.0, 70.0);
      EXPECT_LE(sampled, bound) << i;
      EXPECT_GE(1.02 * sampled, bound) << i;  // 1 % of the search, and what the grid misses
    }
  }
}

TEST(TableForm, BoundOfAParabolaIsTheTextbookOne) {
  // linear interpolation: h²/8 max|f''|; h = 1 °C, f'' = 0.002
  const Curve parabola = SplineCurve{{-30.0, 70.0}, {{0.5, -0.01, 0.001, 0.0}}};
  const auto result = table_form(with_bias(parabola), 101);
  ASSERT_TRUE(result);
  EXPECT_EQ(bias_table(*result).step_c, 1.0);
  EXPECT_GE(*bias_table(*result).bound, 0.00025 * (1.0 - 1e-9));
  EXPECT_LE(*bias_table(*result).bound, 0.00025 * 1.01);
}

TEST(TableForm, HalfTheStepQuartersTheBound) {
  const Calibration calibration = golden_fis();
  const double coarse = *bias_table(*table_form(calibration, 101)).bound;
  const double fine = *bias_table(*table_form(calibration, 201)).bound;
  // the third derivative moves where the worst interval lies
  EXPECT_NEAR(coarse / fine, 4.0, 0.2);
}

TEST(TableForm, KeepsTheNumberOfPointsCoversTheRangeAndMeetsTheCurveAtItsEnds) {
  base::Random random(22);
  for (int i = 0; i < 300; ++i) {
    Calibration calibration = with_bias(spline(1.0));
    SensorCalibration& sensor = calibration.sensors[0];
    sensor.temp_min_c = random.uniform(-30.0, 20.0);
    sensor.temp_max_c = sensor.temp_min_c + 50.0 * std::pow(random.uniform(), 4.0);
    const int points = 2 + static_cast<int>(random.uniform(0.0, 254.999));
    const auto result = table_form(calibration, points);
    ASSERT_TRUE(result) << result.error().message;
    const TableCurve& table = bias_table(*result);
    ASSERT_LE(table.values.size(), static_cast<std::size_t>(points));
    EXPECT_LE(table.first_c, sensor.temp_min_c);
    const double last_c = table.first_c + table.step_c * static_cast<double>(table.values.size() - 1);
    EXPECT_GE(last_c, sensor.temp_max_c);
    for (const double exact : {table.first_c, table.step_c, last_c}) {
      EXPECT_EQ(static_cast<double>(static_cast<float>(exact)), exact);
    }
    for (const double end_c : {sensor.temp_min_c, sensor.temp_max_c}) {
      EXPECT_NEAR(evaluate(table, end_c), evaluate(sensor.bias, end_c), 1e-9);
    }
  }
}

TEST(TableForm, KinkAtTheCentreOfABluntBellIsBoundedToo) {
  base::Random random(23);
  const Curve curve = random_model(random, anfis::Shape::bell, 0.3);  // 2b < 1: infinite slope at the centres
  const auto result = table_form(with_bias(curve), 64);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_LE(sampled_difference(result->sensors[0].bias, curve, -30.0, 70.0), *bias_table(*result).bound);
}

TEST(TableForm, ScaleCurveWithAShorterDomainIsHeldAsTheCurveIs) {
  Calibration calibration = with_bias(spline(0.1), Sensor::accel_x);
  calibration.sensors[0].scale_ppm = SplineCurve{{-10.0, 50.0}, {{500.0, 8.0, 0.0, 0.0}}};
  const auto result = table_form(calibration, 128);
  ASSERT_TRUE(result);
  const auto& table = std::get<TableCurve>(*result->sensors[0].scale_ppm);
  EXPECT_LE(sampled_difference(table, *calibration.sensors[0].scale_ppm, -30.0, 70.0), *table.bound);
  EXPECT_NEAR(evaluate(table, -25.0), 500.0, 1e-9);
}

TEST(TableForm, FileCarriesTheBoundAndTheRuntimeStaysWithinWhatItStates) {
  base::Random random(24);
  for (const Calibration& calibration : {golden_fis(), golden_mixed()}) {
    const auto form = table_form(calibration, 100);
    ASSERT_TRUE(form);
    const auto bytes = encode(*form);
    ASSERT_TRUE(bytes) << bytes.error().message;
    soak_cal cal;
    ASSERT_EQ(soak_load(&cal, bytes->data(), bytes->size()), SOAK_OK);
    for (const SensorCalibration& sensor : calibration.sensors) {
      const int index = static_cast<int>(index_of(sensor.sensor));
      float bound = NAN;
      ASSERT_EQ(soak_curve_error(&cal, index, 0, &bound), SOAK_OK);
      for (int i = 0; i < 2000; ++i) {
        const auto temp_c = static_cast<float>(random.uniform(sensor.temp_min_c, sensor.temp_max_c));
        float value = NAN;
        ASSERT_EQ(soak_bias(&cal, index, temp_c, &value), SOAK_OK);
        const double expected = evaluate(sensor.bias, static_cast<double>(temp_c));
        // 0x0030 is the largest of the encoder's samples, not a proof: between them rounding noise may reach twice that
        const double float32 = static_cast<double>(soak_f32(cal.sensor[index].error_bound[0] + 4));
        ASSERT_LE(std::abs(static_cast<double>(value) - expected), static_cast<double>(bound) + float32);
      }
    }
  }
}

TEST(TableForm, DecodedFileHasTheBoundRoundedUp) {
  const auto form = table_form(golden_fis(), 100);
  const auto read = decode(*encode(*form));
  ASSERT_TRUE(read);
  for (std::size_t i = 0; i < kSensorCount; ++i) {
    const double bound = *std::get<TableCurve>(form->sensors[i].bias).bound;
    const double in_file = std::get<TableCurve>(read->sensors[i].bias).bound.value();
    EXPECT_GE(in_file, bound);
    EXPECT_LE(in_file, bound * (1.0 + 0x1p-23));
  }
}

TEST(TableForm, SmallTableStaysAndALargeOneAddsItsOwnBound) {
  const Calibration small = *table_form(with_bias(table(0.1)), 64);
  EXPECT_FALSE(bias_table(small).bound);
  EXPECT_EQ(bias_table(small).values, table(0.1).values);
  const Curve model = fis(0, anfis::Shape::bell, 0.01, 0.004);
  const Calibration fine = *table_form(with_bias(model), 256);
  const Calibration coarse = *table_form(fine, 40);
  EXPECT_GT(*bias_table(coarse).bound, *bias_table(fine).bound);
  EXPECT_LE(sampled_difference(coarse.sensors[0].bias, model, -30.0, 70.0), *bias_table(coarse).bound);
}

TEST(TableForm, RefusesOtherNumbersOfPoints) {
  for (const int points : {-1, 0, 1, 257}) {
    const auto result = table_form(golden_fis(), points);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().where, "points");
  }
}

TEST(TableForm, RefusesAModelWhoseRulesLeaveAGap) {
  const Curve needles = fis_of(anfis::Shape::gaussian, {{1e-3, 0.0, -0.9, 0.0, 1.0}, {1e-3, 0.0, 0.9, 0.0, 2.0}},
                               {20.0, 50.0}, {0.01, 0.004});
  const auto result = table_form(with_bias(needles), 64);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().where, "gyro_x");
}

base::Bytes bound_payload(std::uint8_t sensor, float bound) {
  base::Bytes payload(8, 0);
  payload[0] = sensor;
  put(payload, 4, bound);
  return payload;
}

soak_status load_with(base::Bytes bytes, const base::Bytes& payload) {
  append_section(bytes, SOAK_SECTION_TABLE_BOUND, 1, false, payload);
  soak_cal cal;
  return soak_load(&cal, bytes.data(), bytes.size());
}

TEST(TableBoundSection, IsRefusedWhereItBreaksTheFormat) {
  const base::Bytes tables = *encode(with_bias(table(0.1)));
  EXPECT_EQ(load_with(tables, bound_payload(0, 1e-6F)), SOAK_OK);
  EXPECT_EQ(load_with(tables, bound_payload(0, -1e-6F)), SOAK_E_FORMAT);
  EXPECT_EQ(load_with(tables, bound_payload(0, NAN)), SOAK_E_FORMAT);
  EXPECT_EQ(load_with(tables, bound_payload(1, 1e-6F)), SOAK_E_FORMAT);  // no such sensor in the file
  EXPECT_EQ(load_with(tables, bound_payload(7, 1e-6F)), SOAK_E_FORMAT);
  EXPECT_EQ(load_with(tables, {0, 0, 0, 0}), SOAK_E_FORMAT);
  EXPECT_EQ(load_with(*encode(with_bias(spline(0.1))), bound_payload(0, 1e-6F)), SOAK_E_FORMAT);
  base::Bytes twice = tables;
  append_section(twice, SOAK_SECTION_TABLE_BOUND, 1, false, bound_payload(0, 1e-6F));
  EXPECT_EQ(load_with(twice, bound_payload(0, 1e-6F)), SOAK_E_FORMAT);
}

TEST(TableBoundSection, CurveErrorIsAbsentWhereTheFileDoesNotSay) {
  const base::Bytes bytes = *encode(with_bias(table(0.1)));
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  float bound = 0.0F;
  EXPECT_EQ(soak_curve_error(&cal, SOAK_GYRO_X, 0, &bound), SOAK_OK);
  EXPECT_GT(bound, 0.0F);
  EXPECT_EQ(soak_curve_error(&cal, SOAK_GYRO_X, 1, &bound), SOAK_ABSENT);
  EXPECT_TRUE(std::isnan(bound));
  EXPECT_EQ(soak_curve_error(&cal, SOAK_GYRO_X, 2, &bound), SOAK_E_ARGUMENT);
}

}  // namespace
}  // namespace soak::calib
