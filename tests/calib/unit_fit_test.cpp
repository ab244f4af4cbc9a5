// SPDX-License-Identifier: Apache-2.0
#include "calib/model/unit_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/units.h"
#include "calib/estimate/branches.h"
#include "calib/judge/verification.h"
#include "calib/model/model_document.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

double gyro_truth(double temp_c) { return 2e-3 * std::tanh((temp_c - 10.0) / 30.0); }
double accel_truth(double temp_c) { return 0.1 - 1e-3 * temp_c; }

/// Six positions at eleven plateaus up and down, all sensors alike but for their axes.
RunInput make_run(const std::string& label, double offset, std::uint64_t seed, double shift_c = 0.0) {
  RunInput run;
  run.run_id = "id-" + label;
  run.label = label;
  run.campaign = "c";
  run.content_sha256 = std::string(62, 'a') + label.substr(label.size() - 1) + std::to_string(seed % 10);
  run.site.gravity_mps2 = base::kStandardGravity_mps2;
  base::Random random(seed);
  double t_s = 0.0;
  for (int visit = 0; visit < 21; ++visit) {
    const double level_c = (visit < 11 ? -30.0 + 10.0 * visit : 70.0 - 10.0 * (visit - 10)) + shift_c;
    for (const auto name : kSixPositionLabels) {
      Segment s;
      s.key = {run.run_id, "U", visit, std::string(name), 0};
      s.plateau_c = level_c;
      s.sweep = visit < 11 ? Sweep::up : Sweep::down;
      s.position = *position_named(name);
      s.t_start_s = t_s;
      s.t_end_s = t_s += 600.0;
      s.temp_c = level_c + 0.02 * random.gaussian();
      s.sensor_temp_c.fill(s.temp_c);
      for (const Sensor sensor : kSensors) {
        const double noise = is_gyro(sensor) ? 2e-5 : 1e-3;
        const double f = base::kStandardGravity_mps2 * s.position->up[axis_of(sensor)];
        const double mean = is_gyro(sensor) ? gyro_truth(s.temp_c) + offset : accel_truth(s.temp_c) + 1.001 * f;
        s.sensor[index_of(sensor)] = {600, mean + noise * random.gaussian(), 600 * noise * noise, noise};
      }
      run.segments.push_back(s);
    }
  }
  return run;
}

UnitInput make_input() {
  UnitInput input;
  input.unit = "U";
  for (int r = 0; r < 4; ++r) {
    input.runs.push_back(make_run("R" + std::to_string(r), 3e-4 * (r - 1.5), static_cast<std::uint64_t>(10 + r)));
  }
  return input;
}

UnitModel fit_all(const UnitInput& input) {
  const auto rows = make_rows(input);
  if (!rows) throw std::runtime_error(rows.error().message);
  std::array<std::optional<SensorFit>, kSensorCount> fits;
  for (const Sensor sensor : kSensors) {
    if (!rows->bias[index_of(sensor)]) continue;
    auto fit = fit_sensor(*rows, sensor, {});
    if (!fit) throw std::runtime_error(fit.error().message);
    fits[index_of(sensor)] = *std::move(fit);
  }
  return make_model(*rows, std::move(fits));
}

bool warns(const std::vector<Warning>& warnings, const std::string& code) {
  return std::any_of(warnings.begin(), warnings.end(), [&](const Warning& w) { return w.code == code; });
}

TEST(UnitFit, RecoversBiasAndScaleOfAllSensors) {
  const UnitModel model = fit_all(make_input());
  for (const Sensor sensor : kSensors) {
    const SensorFit& fit = *model.sensors[index_of(sensor)];
    for (double t = -25.0; t <= 65.0; t += 5.0) {
      const double truth = is_gyro(sensor) ? gyro_truth(t) : accel_truth(t);
      EXPECT_NEAR(evaluate(fit.bias.curve, t), truth, is_gyro(sensor) ? 3e-5 : 1.5e-3) << name_of(sensor) << ' ' << t;
      if (!is_gyro(sensor)) {
        EXPECT_NEAR(evaluate(fit.scale->curve, t), 1000.0, 150.0);
      }
    }
    EXPECT_EQ(fit.scale.has_value(), !is_gyro(sensor));
  }
  EXPECT_TRUE(model.accel_misalignment);
  EXPECT_FALSE(model.gravity.assumed);
  EXPECT_EQ(model.runs.size(), 4U);
}

TEST(UnitFit, StoredDocumentGivesBackTheSameCalibration) {
  UnitModel model = fit_all(make_input());
  model.version = 3;
  const auto document = model_document(model);
  ASSERT_TRUE(document);
  const auto restored = calibration_of(*document);
  ASSERT_TRUE(restored);
  const Calibration original = make_calibration(model);
  EXPECT_EQ(restored->model_version, 3);
  EXPECT_EQ(restored->run_hashes, original.run_hashes);
  ASSERT_EQ(restored->sensors.size(), 6U);
  for (std::size_t s = 0; s < 6; ++s) {
    for (double t = -30.0; t <= 70.0; t += 3.3) {
      EXPECT_EQ(evaluate(restored->sensors[s].bias, t), evaluate(original.sensors[s].bias, t));
    }
    EXPECT_EQ(restored->sensors[s].bias_uncertainty.pi95, original.sensors[s].bias_uncertainty.pi95);
  }
  EXPECT_EQ(restored->accel_misalignment, original.accel_misalignment);
}

TEST(UnitFit, RefusesADamagedStoredDocument) {
  const auto damaged = calibration_of("{\"format\": \"soak-model\", \"format_version\": 1}");
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().kind, base::ErrorKind::corrupt);
  const auto newer = calibration_of("{\"format\": \"soak-model\", \"format_version\": 99}");
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().kind, base::ErrorKind::bad_input);
  EXPECT_FALSE(calibration_of("no json"));
}

TEST(UnitFit, RefusesAStuckSensorNamingRunsAndRemedy) {
  UnitInput input = make_input();
  for (RunInput& run : input.runs) {
    for (Segment& s : run.segments) s.sensor[1] = {600, 0.25, 0.0, 0.0};
  }
  const auto rows = make_rows(input);
  EXPECT_TRUE(is_bad_input(rows, {"gyro_y", "unit U", "14.3239", "'R0'"}));
}

TEST(UnitFit, LeavesOutWhatTheDataGateRejectedAndSaysSo) {
  UnitInput input = make_input();
  // Readings that would spoil the fit, in a segment of one run and in a sensor of a segment of two.
  Segment& moved = input.runs[1].segments[4];
  for (SensorStatistics& sensor : moved.sensor) sensor.mean += 1.0;
  moved.findings = {{"moved", Severity::reject, std::nullopt, "by 3 deg"}};
  for (const std::size_t run : {0U, 2U}) {
    Segment& dead = input.runs[run].segments[10];
    dead.sensor[0].mean += 1.0;
    dead.findings = {{"stuck", Severity::reject, Sensor::gyro_x, "gyro_x repeats 1"}};
  }
  UnitInput without = make_input();
  without.runs[1].segments.erase(without.runs[1].segments.begin() + 4);
  for (const std::size_t run : {0U, 2U}) without.runs[run].segments[10].sensor[0] = {};
  const auto rows = make_rows(input);
  const auto expected = make_rows(without);
  ASSERT_TRUE(rows) << rows.error().message;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    ASSERT_EQ(rows->bias[s]->rows.size(), expected->bias[s]->rows.size());
    for (std::size_t i = 0; i < rows->bias[s]->rows.size(); ++i) {
      EXPECT_EQ(rows->bias[s]->rows[i].value, expected->bias[s]->rows[i].value);
      EXPECT_EQ(rows->bias[s]->rows[i].standard_error, expected->bias[s]->rows[i].standard_error);
    }
  }
  ASSERT_GE(rows->warnings.size(), 2U);
  EXPECT_EQ(rows->warnings[0].code, "stuck");
  EXPECT_TRUE(base::mentions_in_order(rows->warnings[0].text,
                                      {"R0", "stuck", "1", "126", "visit 1", "+Z", "gyro_x repeats 1", "1"}));
  EXPECT_EQ(rows->warnings[1].code, "moved");
  EXPECT_TRUE(
      base::mentions_in_order(rows->warnings[1].text, {"R1", "moved", "1", "126", "visit 0", "+Z", "by 3 deg"}));
}

TEST(UnitFit, RefusesAUnitOfWhichTheDataGateLeavesNothing) {
  UnitInput input = make_input();
  for (RunInput& run : input.runs) {
    for (Segment& s : run.segments) s.findings = {{"moved", Severity::reject, std::nullopt, "by 3 deg"}};
  }
  const auto rows = make_rows(input);
  EXPECT_TRUE(is_bad_input(rows, {"unit U", "R0", "moved", "126"}));
}

TEST(UnitFit, RefusesAUnitWithoutRuns) { EXPECT_FALSE(make_rows(UnitInput{.unit = "U"})); }

TEST(UnitFit, LeavesOutASensorThatWasNotRecorded) {
  UnitInput input = make_input();
  for (RunInput& run : input.runs) {
    for (Segment& s : run.segments) s.sensor[5] = {};
  }
  const UnitModel model = fit_all(input);
  EXPECT_FALSE(model.sensors[5]);
  EXPECT_TRUE(model.sensors[4]);
  EXPECT_FALSE(model.accel_misalignment);
}

// The station turns its fixture while a unit that was switched on at a plateau records: its gyros' scale shows at that
// temperature, and in no pass over the others.
TEST(UnitFit, AScaleThatShowsAtOnePlateauAloneIsLeftOutAndSaid) {
  auto rows = make_rows(make_input());
  ASSERT_TRUE(rows);
  CurveData scale = rows->scale[index_of(Sensor::accel_x)].value();
  std::erase_if(scale.rows, [](const CurveRow& row) { return std::abs(row.temp_c - 10.0) > 1.0; });
  rows->scale[index_of(Sensor::gyro_x)] = scale;
  const auto fit = fit_sensor(*rows, Sensor::gyro_x, {});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_FALSE(fit->scale);
  EXPECT_TRUE(warns(fit->warnings, "scale_left_out"));
  EXPECT_NEAR(evaluate(fit->bias.curve, 25.0), gyro_truth(25.0), 3e-5);
}

TEST(UnitFit, AnAccelerometersScaleAtOnePlateauAloneIsRefused) {
  auto rows = make_rows(make_input());
  ASSERT_TRUE(rows);
  std::erase_if(rows->scale[index_of(Sensor::accel_x)].value().rows,
                [](const CurveRow& row) { return std::abs(row.temp_c - 10.0) > 1.0; });
  EXPECT_FALSE(fit_sensor(*rows, Sensor::accel_x, {}));
}

TEST(UnitFit, OneAttitudeGivesAccelerometerBiasRelativeTo25Degrees) {
  UnitInput input = make_input();
  for (RunInput& run : input.runs) {
    std::erase_if(run.segments, [](const Segment& s) { return s.key.position != "+Z"; });
    for (Segment& s : run.segments) {
      s.position.reset();
      s.key.position.clear();
    }
  }
  const UnitModel model = fit_all(input);
  EXPECT_TRUE(model.sensors[5]->relative);
  EXPECT_NEAR(evaluate(model.sensors[5]->bias.curve, 25.0), 0.0, 1e-12);
  EXPECT_NEAR(evaluate(model.sensors[5]->bias.curve, -25.0), accel_truth(-25.0) - accel_truth(25.0), 3e-3);
  EXPECT_FALSE(model.sensors[5]->scale);
  EXPECT_TRUE(warns(model.warnings, "one_attitude"));
}

TEST(UnitFit, NamesRunsByCampaignWhereLabelsClash) {
  UnitInput input = make_input();
  input.runs[1].label = input.runs[0].label;
  input.runs[1].campaign = "d";
  const auto rows = make_rows(input);
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->bias[0]->runs[0], "c/R0");
  EXPECT_EQ(rows->bias[0]->runs[1], "d/R0");
}

TEST(Branches, CutsAHistoryAtItsTurningPoints) {
  std::vector<double> temps;
  for (double t = 50; t > -17; t -= 1) temps.push_back(t);
  for (double t = -17; t < 74; t += 1) temps.push_back(t + 0.5 * std::sin(t * 3.0));
  for (double t = 74; t > 36; t -= 1) temps.push_back(t);
  const auto branches = find_branches(temps, 3.0);
  ASSERT_EQ(branches.size(), 3U);
  EXPECT_EQ(branches[0].sweep, Sweep::down);
  EXPECT_EQ(branches[1].sweep, Sweep::up);
  EXPECT_EQ(branches[2].sweep, Sweep::down);
  EXPECT_EQ(branches[0].first, 0U);
  EXPECT_NEAR(static_cast<double>(branches[1].first), 67.0, 1.0);
  EXPECT_NEAR(static_cast<double>(branches[2].first), 158.0, 1.0);
  EXPECT_EQ(branches[2].last, temps.size());
}

TEST(Branches, AHistoryThatStandsStillIsOneBranch) {
  const auto branches = find_branches(std::vector<double>(20, 25.0), 3.0);
  ASSERT_EQ(branches.size(), 1U);
  EXPECT_EQ(branches[0].sweep, Sweep::unknown);
}

class VerificationTest : public ::testing::Test {
 protected:
  static const Calibration& shared_calibration() {
    static const Calibration calibration = make_calibration(fit_all(make_input()));
    return calibration;
  }
  const Calibration& calibration = shared_calibration();

  UnitInput fresh(double offset) const {
    UnitInput input;
    input.unit = "U";
    input.runs.push_back(make_run("V7", offset, 77, 5.0));
    input.runs.back().segments.resize(60);  // the way up, inside the range
    return input;
  }
};

TEST_F(VerificationTest, WithoutLimitsItInformsAndNeverPasses) {
  const auto result = verify(calibration, fresh(2e-4), {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->verdict, Verdict::info);
  const SensorVerification& gyro = *result->sensors[0];
  EXPECT_NEAR(gyro.rmse_abs, 2e-4, 5e-5);
  EXPECT_LT(gyro.rmse_shape, 3e-5);
  EXPECT_EQ(gyro.rows, 10U);
}

TEST_F(VerificationTest, JudgesWithAGuardBandOfTheRowsOwnUncertainty) {
  Limits limits;
  limits.bias.fill(1.0);
  limits[0] = 5e-4;
  EXPECT_EQ(verify(calibration, fresh(0.0), limits)->verdict, Verdict::pass);
  EXPECT_EQ(verify(calibration, fresh(2e-3), limits)->sensors[0]->verdict, Verdict::fail);
  EXPECT_EQ(verify(calibration, fresh(2e-3), limits)->verdict, Verdict::fail);
  const double worst = verify(calibration, fresh(3e-4), limits)->sensors[0]->worst_abs;
  limits[0] = worst + 1e-6;  // within the standard error of the row
  EXPECT_EQ(verify(calibration, fresh(3e-4), limits)->verdict, Verdict::marginal);
}

TEST_F(VerificationTest, DoesNotPassAUnitWithASensorWithoutLimit) {
  Limits limits;
  limits[0] = 1.0;
  EXPECT_EQ(verify(calibration, fresh(0.0), limits)->verdict, Verdict::info);
}

TEST_F(VerificationTest, RefusesARunThatTheFitHasSeen) {
  const auto result = verify(calibration, make_input(), {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, base::ErrorKind::bad_input);
  EXPECT_NE(result.error().message.find("R0"), std::string::npos);
}

}  // namespace
}  // namespace soak::calib
