// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/calibration_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kHalfStep = 0x1p-24;  // of float32, relative

double largest_difference(const Curve& a, const Curve& b) {
  double worst = 0.0;
  for (double t = -40.0; t <= 80.0; t += 0.0625) worst = std::max(worst, std::abs(evaluate(a, t) - evaluate(b, t)));
  return worst;
}

void expect_same_table(const UncertaintyTable& a, const UncertaintyTable& b) {
  ASSERT_EQ(a.temp_c.size(), b.temp_c.size());
  ASSERT_EQ(a.pi95.size(), b.pi95.size());
  for (std::size_t i = 0; i < a.temp_c.size(); ++i) {
    EXPECT_EQ(a.temp_c[i], b.temp_c[i]);
    EXPECT_NEAR(a.ci95[i], b.ci95[i], kHalfStep * b.ci95[i]);
    if (a.pi95.empty()) continue;
    EXPECT_NEAR(a.pi95[i], b.pi95[i], kHalfStep * b.pi95[i]);
  }
}

TEST(CalibrationFile, KeepsProvenanceExactly) {
  for (const Calibration& written : {golden_fis(), golden_mixed(), golden_unreleased()}) {
    const auto bytes = encode(written);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto read = decode(*bytes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->unit, written.unit);
    EXPECT_EQ(read->unit_type, written.unit_type);
    EXPECT_EQ(read->epoch, written.epoch);
    EXPECT_EQ(read->model_version, written.model_version);
    EXPECT_EQ(read->created_utc_s, written.created_utc_s);
    EXPECT_EQ(read->simulated, written.simulated);
    EXPECT_EQ(read->unreleased, written.unreleased);
    EXPECT_EQ(read->gravity_mps2, written.gravity_mps2);
    EXPECT_EQ(read->gravity_assumed, written.gravity_assumed);
    EXPECT_EQ(read->run_hashes, written.run_hashes);
  }
}

TEST(CalibrationFile, KeepsEveryCurveToFloat32) {
  for (const Calibration& written : {golden_fis(), golden_mixed()}) {
    const auto read = decode(*encode(written));
    ASSERT_TRUE(read);
    ASSERT_EQ(read->sensors.size(), written.sensors.size());
    for (std::size_t i = 0; i < written.sensors.size(); ++i) {
      const SensorCalibration& before = written.sensors[i];
      const SensorCalibration& after = read->sensors[i];
      EXPECT_EQ(after.sensor, before.sensor);
      EXPECT_EQ(after.model, before.model);
      EXPECT_EQ(after.temp_min_c, before.temp_min_c);
      EXPECT_EQ(after.temp_max_c, before.temp_max_c);
      EXPECT_EQ(after.bias.index(), before.bias.index());
      // spans of the samples' curves: over 0.004 rad/s, 0.1 m/s², 400 ppm
      EXPECT_LT(largest_difference(after.bias, before.bias), is_gyro(before.sensor) ? 4e-9 : 1e-7);
      expect_same_table(after.bias_uncertainty, before.bias_uncertainty);
      ASSERT_EQ(after.scale_ppm.has_value(), before.scale_ppm.has_value());
      ASSERT_EQ(after.scale_uncertainty.has_value(), before.scale_uncertainty.has_value());
      if (before.scale_uncertainty) expect_same_table(*after.scale_uncertainty, *before.scale_uncertainty);
      if (!before.scale_ppm) continue;
      EXPECT_LT(largest_difference(*after.scale_ppm, *before.scale_ppm), 4e-4);
    }
  }
}

TEST(CalibrationFile, KeepsCrossTermsAndAcceptedTerms) {
  const Calibration written = golden_mixed();
  const auto read = decode(*encode(written));
  ASSERT_TRUE(read);
  ASSERT_TRUE(read->accel_misalignment && read->g_sensitivity);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_FLOAT_EQ(static_cast<float>((*read->accel_misalignment)[i][j]),
                      static_cast<float>((*written.accel_misalignment)[i][j]));
      EXPECT_FLOAT_EQ(static_cast<float>((*read->g_sensitivity)[i][j]),
                      static_cast<float>((*written.g_sensitivity)[i][j]));
    }
  }
  ASSERT_EQ(read->terms.size(), 1U);
  EXPECT_EQ(read->terms[0].name, "temperature_rate");
  EXPECT_FALSE(read->terms[0].lab_only);
  EXPECT_EQ(read->terms[0].sensors, written.terms[0].sensors);
  ASSERT_EQ(read->terms[0].parameters.size(), 2U);
  EXPECT_EQ(read->terms[0].parameters[1].first, "gyro_z");
  EXPECT_NEAR(read->terms[0].parameters[1].second, -2e-4, 2e-4 * kHalfStep);
}

TEST(CalibrationFile, IsTheSameForTheSameCalibration) { EXPECT_EQ(*encode(golden_mixed()), *encode(golden_mixed())); }

TEST(CalibrationFile, WritesDecodedCurvesAgainWithoutFurtherLoss) {
  const auto once = decode(*encode(golden_fis()));
  ASSERT_TRUE(once);
  const auto twice = decode(*encode(*once));
  ASSERT_TRUE(twice);
  EXPECT_LT(largest_difference(once->sensors[0].bias, twice->sensors[0].bias), 4e-9);
}

TEST(CalibrationFile, CarriesConstantCurves) {
  for (const double value : {0.0, 0.1, -3000.0, 1e-12}) {
    const auto bytes = encode(with_bias(TableCurve{20.0, 1.0, {value}}));
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto read = decode(*bytes);
    ASSERT_TRUE(read);
    EXPECT_NEAR(evaluate(read->sensors[0].bias, 0.0), value, kHalfStep * std::abs(value));
  }
}

TEST(CalibrationFile, CarriesALargeConstantUnderASmallShape) {
  // 1000 ppm with 100 ppm of shape: float32 steps are 6e-5 ppm there, 6e-7 of the span
  Calibration calibration = with_bias(TableCurve{20.0, 1.0, {0.0}}, Sensor::accel_x);
  calibration.sensors[0].scale_ppm = SplineCurve{{-30.0, 70.0}, {{1000.0, 1.0, 0.0, 0.0}}};
  EXPECT_TRUE(encode(calibration));
}

TEST(CalibrationFile, CarriesATableUpToTheHighestTemperature) {
  // 3000 times the float32 third is 1000.00003, which rounds to 1000
  EXPECT_TRUE(encode(with_bias(TableCurve{0.0, 1.0 / 3.0, std::vector<double>(3001, 1.0)})));
}

TEST(CalibrationFile, CarriesEveryFiniteHalfWidth) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  Calibration calibration = golden_fis();
  calibration.sensors[0].bias_uncertainty.ci95[0] = kLargest;
  const auto bytes = encode(calibration);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(decode(*bytes)->sensors[0].bias_uncertainty.ci95[0], kLargest);
}

TEST(CalibrationFile, LeavesOutAnEmptyUncertaintyTable) {
  const auto read = decode(*encode(with_bias(table(0.1))));
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->sensors[0].bias_uncertainty.temp_c.empty());
}

struct Refusal {
  const char* name;
  std::function<void(Calibration&)> spoil;
};

anfis::Model& model_of(Calibration& calibration) { return std::get<anfis::Model>(calibration.sensors[0].bias); }

anfis::Membership& membership_of(Calibration& calibration) { return model_of(calibration).inputs[0].memberships[1]; }

const Refusal kRefusals[] = {
    {"no unit", [](Calibration& c) { c.unit.clear(); }},
    {"long serial number", [](Calibration& c) { c.unit.assign(256, 'x'); }},
    {"time not finite", [](Calibration& c) { c.created_utc_s = kNaN; }},
    {"hash not hexadecimal", [](Calibration& c) { c.run_hashes[0][5] = 'g'; }},
    {"hash too short", [](Calibration& c) { c.run_hashes[0].pop_back(); }},
    {"no sensor", [](Calibration& c) { c.sensors.clear(); }},
    {"sensor twice", [](Calibration& c) { c.sensors.push_back(c.sensors[0]); }},
    {"reversed range", [](Calibration& c) { std::swap(c.sensors[0].temp_min_c, c.sensors[0].temp_max_c); }},
    {"range not finite", [](Calibration& c) { c.sensors[0].temp_max_c = kNaN; }},
    {"below absolute zero", [](Calibration& c) { c.sensors[0].temp_min_c = -300.0; }},
    {"no rules", [](Calibration& c) { model_of(c).rules.clear(); }},
    {"too many rules",
     [](Calibration& c) {
       c.sensors[0].bias = anfis::curve_model(anfis::Shape::bell, std::vector<anfis::CurveRule>(65, {1.0, 2.0}));
     }},
    {"width 0", [](Calibration& c) { membership_of(c) = anfis::bell(0.0, 2.0, 0.0); }},
    {"gain not finite", [](Calibration& c) { model_of(c).rules[1].gains[0] = kNaN; }},
    {"centre far away", [](Calibration& c) { membership_of(c) = anfis::bell(1.0, 2.0, 1e6); }},
    {"empty table", [](Calibration& c) { c.sensors[0].bias = TableCurve{}; }},
    {"table step 0", [](Calibration& c) { c.sensors[0].bias = TableCurve{0.0, 0.0, {1.0, 2.0}}; }},
    {"table beyond 1000 °C in float32",  // 3000 * 0.3f = 900.00004: rounds to 900.00006, not to 900
     [](Calibration& c) { c.sensors[0].bias = TableCurve{100.0, 0.3, std::vector<double>(3001, 1.0)}; }},
    {"table value not finite", [](Calibration& c) { c.sensors[0].bias = TableCurve{0.0, 1.0, {1.0, kNaN}}; }},
    {"spline without pieces", [](Calibration& c) { c.sensors[0].bias = SplineCurve{}; }},
    {"knots equal in float32",
     [](Calibration& c) { c.sensors[0].bias = SplineCurve{{20.0, 20.0 + 1e-9, 30.0}, {{}, {}}}; }},
    {"one knot too few", [](Calibration& c) { c.sensors[0].bias = SplineCurve{{20.0}, {{}}}; }},
    {"scale of 60 %", [](Calibration& c) { c.sensors[0].scale_ppm = TableCurve{20.0, 1.0, {600000.0}}; }},
    {"half-width negative", [](Calibration& c) { c.sensors[0].bias_uncertainty.ci95[0] = -1.0; }},
    {"half-width not finite", [](Calibration& c) { c.sensors[0].bias_uncertainty.pi95[0] = kNaN; }},
    {"half-widths missing", [](Calibration& c) { c.sensors[0].bias_uncertainty.ci95.pop_back(); }},
    {"uncertainty not rising", [](Calibration& c) { c.sensors[0].bias_uncertainty.temp_c[1] = -30.0; }},
    {"misalignment on the diagonal", [](Calibration& c) { c.accel_misalignment = {{{0.1, 0, 0}, {}, {}}}; }},
    {"misalignment of 0.3", [](Calibration& c) { c.accel_misalignment = {{{0, 0.3, 0}, {}, {}}}; }},
    {"g-sensitivity not finite", [](Calibration& c) { c.g_sensitivity = {{{kNaN, 0, 0}, {}, {}}}; }},
    {"term without name", [](Calibration& c) { c.terms = {{"", false, {}, {}}}; }},
    {"term not finite", [](Calibration& c) { c.terms = {{"temperature_rate", false, {}, {{"k", kNaN}}}}; }},
    {"33 terms", [](Calibration& c) { c.terms.assign(33, {"temperature_rate", false, {}, {}}); }},
};

TEST(CalibrationFile, RefusesWhatTheFormatCannotCarryAndSaysWhere) {
  for (const Refusal& refusal : kRefusals) {
    Calibration calibration = golden_fis();
    refusal.spoil(calibration);
    const auto bytes = encode(calibration);
    ASSERT_FALSE(bytes) << refusal.name;
    EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input) << refusal.name;
    EXPECT_FALSE(bytes.error().message.empty() || bytes.error().where.empty()) << refusal.name;
  }
}

/// Models that can be evaluated and that the FIS section has no place for.
const Refusal kForeignModels[] = {
    {"two inputs",
     [](Calibration& c) {
       anfis::Model& model = model_of(c);
       model.inputs.push_back(model.inputs[0]);
       for (anfis::Rule& rule : model.rules) {
         rule.premise.push_back(rule.premise[0]);
         rule.gains.push_back(0.5);
       }
     }},
    {"a triangle", [](Calibration& c) { membership_of(c) = {anfis::Shape::triangle, {-1.0, -0.6, -0.2}}; }},
    {"triangles only",
     [](Calibration& c) {
       for (anfis::Membership& m : model_of(c).inputs[0].memberships) {
         m = {anfis::Shape::triangle, {anfis::centre(m) - 0.5, anfis::centre(m), anfis::centre(m) + 0.5}};
       }
     }},
    {"a Gaussian among bells", [](Calibration& c) { membership_of(c) = anfis::gaussian(0.2, -0.6); }},
    {"a membership that two rules share", [](Calibration& c) { model_of(c).rules[1].premise[0] = 0; }},
    {"a rule that fires everywhere",
     [](Calibration& c) {
       model_of(c).rules.resize(1);
       model_of(c).rules[0].premise[0] = anfis::kAny;
     }},
};

TEST(CalibrationFile, RefusesModelsThatItsFuzzySectionHasNoPlaceFor) {
  for (const Refusal& foreign : kForeignModels) {
    Calibration calibration = golden_fis();
    foreign.spoil(calibration);
    ASSERT_TRUE(anfis::validate(model_of(calibration))) << foreign.name;
    const auto bytes = encode(calibration);
    ASSERT_FALSE(bytes) << foreign.name;
    EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input) << foreign.name;
    EXPECT_EQ(bytes.error().where.find("gyro_x bias"), 0U) << foreign.name << ": " << bytes.error().where;
  }
}

TEST(CalibrationFile, LeavesOutMembershipsThatNoRuleAsksFor) {
  anfis::Model model = fis(0, anfis::Shape::bell, 0.0, 1.0);
  const base::Bytes plain = *encode(with_bias(model));
  model.inputs[0].memberships.push_back({anfis::Shape::triangle, {-1.0, 0.0, 1.0}});
  EXPECT_EQ(*encode(with_bias(model)), plain);
}

TEST(CalibrationFile, WritesAModelWhoseConsequentsCancelAsASpline) {
  // consequents of ±1e7 that cancel: float32 keeps 7 digits, the difference needs 14
  const anfis::Model model =
      fis_of(anfis::Shape::bell, {{1.0, 2.0, 0.0, 0.0, 1e7}, {1.0001, 2.0, 0.0, 0.0, -1e7}}, {20.0, 50.0}, {0.0, 1.0});
  const auto bytes = encode(with_bias(model));
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto read = decode(*bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->sensors[0].model, "anfis");
  EXPECT_TRUE(std::holds_alternative<SplineCurve>(read->sensors[0].bias));
  const double span = std::abs(evaluate(Curve(model), 20.0) - evaluate(Curve(model), 70.0));
  for (double t = -30.0; t <= 70.0; t += 0.0625) {
    EXPECT_NEAR(evaluate(read->sensors[0].bias, t), evaluate(Curve(model), t), 5e-7 * span);
  }
}

TEST(CalibrationFile, WritesAModelWithGapsBetweenItsRulesAsASpline) {
  anfis::Model model = fis(0, anfis::Shape::gaussian, 0.0, 1.0);
  // half-way between two centres 20 widths from both: e^-200
  for (anfis::Membership& m : model.inputs[0].memberships) m = anfis::gaussian(0.01, anfis::centre(m));
  const auto bytes = encode(with_bias(model));
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_TRUE(std::holds_alternative<SplineCurve>(decode(*bytes)->sensors[0].bias));
}

TEST(CalibrationFile, NamesTheSensorOfACurveThatFloat32CannotHold) {
  // 1 of span within 1e-4 °C, at temperatures that float32 knows to 2e-6 °C
  const auto bytes = encode(with_bias(TableCurve{20.1, 1e-4, {0.0, 1.0, 0.0, 1.0}}, Sensor::accel_y));
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(bytes.error().where, "accel_y bias");
}

}  // namespace
}  // namespace soak::calib
