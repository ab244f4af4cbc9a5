// SPDX-License-Identifier: Apache-2.0
// Sessions on a bench from the samples to the constants, against a truth that is generated apart (hand_session.h).
// `tools/prove/bench` runs the coverage on 400 sessions of each kind.
#include "tests/calib/hand_session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "calib/deploy/calibration_file.h"
#include "calib/model/model_document.h"
#include "calib/runtime/soak_runtime.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "tests/long_tests.h"

namespace soak::calib {
namespace {

using test::HandOptions;
using test::HandSession;
using test::HandTruth;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Attitudes spread over the sphere at random: none of them a face.
Recording many_attitudes(const HandTruth& truth, const HandOptions& options, std::uint64_t seed, int count = 24) {
  base::Random random(seed, 7);
  HandSession session(truth, options, seed);
  session.rest();
  for (int n = 1; n < count; ++n) {
    session.tilt_to({random.gaussian(), random.gaussian(), random.gaussian()});
    session.rest();
  }
  return session.recording();
}

/// The six faces by hand, a degree off each, and attitudes on edges; on three faces two turns each way.
Recording ferraris(const HandTruth& truth, const HandOptions& options, std::uint64_t seed, bool named) {
  base::Random random(seed, 8);
  HandSession session(truth, options, seed);
  for (std::string_view label : kSixPositionLabels) {
    Vector3 up = position_named(label)->up;
    if (!named) {
      for (double& x : up) x += 0.02 * random.gaussian();
    }
    session.tilt_to(up);
    session.rest(named ? std::string(label) : "");
    if (label[0] != '+') continue;
    for (const double sign : {1.0, -1.0, 1.0, -1.0}) {
      session.turn(sign * kTurn_rad);
      session.rest(named ? std::string(label) : "");
    }
  }
  if (named) return session.recording();
  for (const Vector3& edge : {Vector3{1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {-1, 1, 0}, {1, 0, -1}, {0, -1, 1}}) {
    session.tilt_to(edge);
    session.rest();
  }
  return session.recording();
}

UnitInput input_of(const Recording& recording, const UnitType& type, const HandOptions& options) {
  Segmentation segmentation = segment(recording).value();
  const auto findings = examine(recording, segmentation.segments, type);
  for (std::size_t i = 0; i < findings.size(); ++i) segmentation.segments[i].findings = findings[i];
  RunInput run;
  run.run_id = run.label = recording.run_id;
  run.content_sha256 = std::string(64, 'a');
  run.campaign = "bench";
  run.site.latitude_deg = options.latitude_rad * base::kDegPerRad;
  run.site.gravity_mps2 = options.gravity_mps2;
  run.segments = segmentation.segments;
  if (is_bench_session(run.segments)) run.moves = moves_between(recording, run.segments, type);
  UnitInput input;
  input.unit = "U";
  input.type = type;
  input.runs = {run};
  return input;
}

base::Result<UnitModel> fit(const UnitInput& input) {
  auto rows = make_rows(input);
  if (!rows) return base::forward_error(rows);
  std::array<std::optional<SensorFit>, kSensorCount> fits;
  for (const Sensor sensor : kSensors) {
    if (!rows->bias[index_of(sensor)]) continue;
    auto fitted = fit_sensor(*rows, sensor, {});
    if (!fitted) return base::forward_error(fitted);
    fits[index_of(sensor)] = *std::move(fitted);
  }
  return make_model(*std::move(rows), std::move(fits));
}

base::Result<UnitModel> fit(const Recording& recording, const HandOptions& options = {}, const UnitType& type = {}) {
  return fit(input_of(recording, type, options));
}

bool warned(const UnitModel& model, const std::string& code) {
  return std::ranges::any_of(model.warnings, [&](const Warning& warning) { return warning.code == code; });
}

/// Error over half-width of every constant of a model, by name.
std::map<std::string, double> errors_over_ci95(const UnitModel& model, const HandTruth& truth) {
  std::map<std::string, double> errors;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const std::size_t i = axis_of(sensor);
    const CurvePoint& bias = model.sensors[s]->bias.points.front();
    const double true_bias = is_gyro(sensor) ? truth.gyro_bias[i] : truth.accel_bias[i];
    errors[std::string(name_of(sensor)) + " bias"] = (bias.value - true_bias) / bias.ci95;
    if (!model.sensors[s]->scale) continue;
    const CurvePoint& scale = model.sensors[s]->scale->points.front();
    const double gain = is_gyro(sensor) ? truth.gyro_gain[i][i] : truth.accel_gain[i][i];
    errors[std::string(name_of(sensor)) + " scale"] = (scale.value - 1e6 * (gain - 1.0)) / scale.ci95;
  }
  const auto add = [&](const std::optional<Coupling>& coupling, const test::Matrix& gains, const char* name) {
    for (std::size_t i = 0; i < 3 && coupling; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const StatedValue& entry = (*coupling)[i][j];
        if (i == j || entry.by_choice) continue;
        errors[std::string(name) + std::to_string(i) + std::to_string(j)] = (entry.value - gains[i][j]) / entry.ci95;
      }
    }
  };
  add(model.accel_misalignment, truth.accel_gain, "accel misalignment ");
  add(model.gyro_misalignment, truth.gyro_gain, "gyro misalignment ");
  return errors;
}

TEST(HandSession, TheGeneratorsRatesAreTheDerivativesOfItsAttitudes) {
  HandTruth exact;
  exact.gyro_gain = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  exact.gyro_bias = {};
  exact.g_sensitivity = {};
  HandOptions quiet;
  quiet.rate_hz = 2000.0;
  quiet.gyro_noise = quiet.gyro_walk = quiet.earth_rps = 0.0;
  HandSession session(exact, quiet, 3);
  session.tilt_to({0, 0, 1});
  const Vector3 before = session.up();
  const std::size_t first = session.recording().rows();
  session.tilt_to({0.3, -0.8, 0.2});
  const Recording r = session.recording();
  // Euler steps of du/dt = -ω × u: errors of the order of the step.
  Vector3 up = before;
  for (std::size_t i = first; i < r.rows(); ++i) {
    const Vector3 rate = {r.sensor[0][i], r.sensor[1][i], r.sensor[2][i]};
    const Vector3 change = test::crossed(rate, up);
    for (std::size_t k = 0; k < 3; ++k) up[k] -= change[k] / quiet.rate_hz;
  }
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(up[k], session.up()[k], 2e-3);
}

TEST(HandSession, AttitudesWithoutAnyLabelGiveEveryConstant) {
  const HandTruth truth;
  const auto model = fit(many_attitudes(truth, {}, 1));
  ASSERT_TRUE(model) << model.error().message;
  for (const auto& [name, error] : errors_over_ci95(*model, truth)) EXPECT_LT(std::abs(error), 2.0) << name;
  ASSERT_TRUE(model->gyro_misalignment && model->accel_misalignment);
  EXPECT_EQ(model->sensors[0]->bias.deployed, Family::constant);
  EXPECT_TRUE(model->sensors[0]->scale);
  for (const Sensor sensor : kSensors) {
    const SensorFit& fit = *model->sensors[index_of(sensor)];
    std::printf("%s: bias ci95 %.2g %s, scale %.0f +- %.0f ppm\n", std::string(name_of(sensor)).c_str(),
                fit.bias.points[0].ci95 * printed_per_si(sensor), std::string(printed_unit(sensor)).c_str(),
                fit.scale->points[0].value, fit.scale->points[0].ci95);
  }
}

TEST(HandSession, NamedFacesAndTurnsOfKnownAngleGiveTheGyrosScale) {
  const HandTruth truth;
  HandOptions options;
  const auto model = fit(ferraris(truth, options, 2, true), options);
  ASSERT_TRUE(model) << model.error().message;
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(model->sensors[i]->scale) << i;
    const CurvePoint& scale = model->sensors[i]->scale->points.front();
    // A turn comes back to 0.003 rad of 2π: 480 ppm; four turns of each axis.
    EXPECT_LT(scale.ci95, 1500.0);
    EXPECT_NEAR(scale.value, 1e6 * (truth.gyro_gain[i][i] - 1.0), 2.0 * scale.ci95);
  }
}

TEST(HandSession, TheFileOfConstantsCorrectsASample) {
  const HandTruth truth;
  UnitType type;
  type.constants_within_c = 5.0;
  type.gyro_bias_per_k_dps = 0.05;
  const auto model = fit(many_attitudes(truth, {}, 4), {}, type);
  ASSERT_TRUE(model) << model.error().message;
  const auto stored = calibration_of(*model_document(*model));
  ASSERT_TRUE(stored) << stored.error().message;
  EXPECT_EQ(stored->gyro_misalignment, make_calibration(*model).gyro_misalignment);
  const auto bytes = encode(*stored);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(decode(*bytes)->sensors[0].model, "constant");
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes->data(), bytes->size()), SOAK_OK);
  const Vector3 rate = {0.7, -1.2, 0.4};
  const Vector3 force = {3.0, -2.0, 8.0};
  const Vector3 gyro = test::times(truth.gyro_gain, rate);
  const Vector3 pull = test::times(truth.g_sensitivity, force);
  const Vector3 accel = test::times(truth.accel_gain, force);
  float raw[6];
  for (std::size_t i = 0; i < 3; ++i) {
    raw[i] = static_cast<float>(gyro[i] + pull[i] + truth.gyro_bias[i]);
    raw[3 + i] = static_cast<float>(accel[i] + truth.accel_bias[i]);
  }
  float out[6];
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply(&cal, 27.0F, raw, out, &flags), SOAK_OK) << flags;
  for (std::size_t i = 0; i < 3; ++i) {
    // g-sensitivity is no part of the file: up to 3e-3 rad/s here.
    EXPECT_NEAR(static_cast<double>(out[i]), rate[i], 3e-3 + 2e-3);
    EXPECT_NEAR(static_cast<double>(out[3 + i]), force[i], 0.01);
  }
  EXPECT_EQ(soak_apply(&cal, 45.0F, raw, out, &flags), SOAK_CLAMPED);
  float near_by = NAN;
  float far_off = NAN;
  float pi95 = NAN;
  ASSERT_EQ(soak_uncertainty(&cal, 0, 24.5F, &near_by, &pi95), SOAK_OK);
  ASSERT_EQ(soak_uncertainty(&cal, 0, 29.5F, &far_off, &pi95), SOAK_OK);
  EXPECT_GT(far_off, near_by);  // 0.05 deg/s per kelvin
  EXPECT_TRUE(std::isnan(pi95));
}

TEST(HandSession, WithoutATypeTheConstantsHoldWhereTheyWereMeasured) {
  const auto model = fit(many_attitudes({}, {}, 5));
  ASSERT_TRUE(model) << model.error().message;
  const CurveFit& bias = model->sensors[0]->bias;
  EXPECT_GT(bias.temp_min_c, 23.9);
  EXPECT_LT(bias.temp_max_c, 25.0);
}

TEST(HandSession, TooFewAttitudesAreRefused) {
  const auto model = fit(many_attitudes({}, {}, 6, 5));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, base::ErrorKind::bad_input);
}

TEST(HandSession, AUnitThatWasNeverTurnedIsRefused) {
  HandOptions options;
  options.rest_s = 300.0;
  HandSession session(HandTruth(), options, 7);
  session.rest();
  const auto model = fit(session.recording());
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, base::ErrorKind::bad_input);
}

TEST(HandSession, TurnsWithoutAnAngleAreToldOf) {
  Recording recording = ferraris({}, {}, 8, true);
  recording.auxiliary.clear();
  const auto model = fit(recording);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_TRUE(warned(*model, "turns_without_angle"));
}

TEST(HandSession, SaturatedMovementsAreLeftOut) {
  UnitType type;
  type.gyro_range_dps = 60.0;
  Recording recording = many_attitudes({}, {}, 9);
  for (std::size_t s = 0; s < 3; ++s) {
    for (double& x : recording.sensor[s]) x = std::clamp(x, -60.0 * base::kRadPerDeg, 60.0 * base::kRadPerDeg);
  }
  const auto model = fit(recording, {}, type);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_TRUE(warned(*model, "turns_saturated"));
  // What is left must not be spoilt by what was left out.
  if (model->sensors[0]->scale) {
    const CurvePoint& scale = model->sensors[0]->scale->points.front();
    EXPECT_NEAR(scale.value, 12000.0, 3.0 * scale.ci95);
  }
}

TEST(HandSession, GyrosWithAWrongSignAreRefused) {
  Recording recording = many_attitudes({}, {}, 10);
  for (double& x : recording.sensor[1]) x = -x;
  const auto model = fit(recording);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, base::ErrorKind::bad_input);
}

TEST(HandSession, AnAccelerometerInAnotherUnitIsRefused) {
  Recording recording = many_attitudes({}, {}, 11);
  for (std::size_t s = 3; s < 6; ++s) {
    for (double& x : recording.sensor[s]) x /= 9.80665;
  }
  const auto model = fit(recording);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, base::ErrorKind::bad_input);
}

TEST(HandSession, PowerOnsScatterIntoTheBandOfAFreshOne) {
  HandTruth truth;
  UnitInput input;
  base::Random random(12);
  for (int run = 0; run < 4; ++run) {
    HandTruth now = truth;
    now.gyro_bias[0] += 0.005 * random.gaussian();
    UnitInput one = input_of(many_attitudes(now, {}, 40 + static_cast<std::uint64_t>(run)), {}, {});
    one.runs[0].label = "R" + std::to_string(run);
    one.runs[0].content_sha256[0] = static_cast<char>('0' + run);
    if (run == 0) input = one;
    if (run > 0) input.runs.push_back(one.runs[0]);
  }
  const auto model = fit(input);
  ASSERT_TRUE(model) << model.error().message;
  const CurveFit& bias = model->sensors[0]->bias;
  ASSERT_TRUE(bias.run_to_run_sigma && bias.points[0].pi95);
  EXPECT_GT(*bias.run_to_run_sigma, 0.001);
  EXPECT_GT(*bias.points[0].pi95, bias.points[0].ci95);
  EXPECT_NEAR(bias.points[0].value, truth.gyro_bias[0], 2.0 * bias.points[0].ci95);
}

int sessions() {
  const char* asked = std::getenv("SOAK_BENCH_SESSIONS");
  return asked == nullptr ? 10 : std::atoi(asked);
}

struct Shares {
  std::map<std::string, int> inside;
  std::map<std::string, int> tried;
};

void print_and_judge(const char* what, const Shares& shares, int failed) {
  int inside = 0;
  int tried = 0;
  for (const auto& [name, count] : shares.tried) {
    const double share = 100.0 * shares.inside.at(name) / count;
    std::printf("%s: %-24s %5.1f %% of %d\n", what, name.c_str(), share, count);
    inside += shares.inside.at(name);
    tried += count;
  }
  const double share = static_cast<double>(inside) / tried;
  std::printf("%s: all %.2f %% of %d, %d sessions refused\n", what, 100.0 * share, tried, failed);
  EXPECT_EQ(failed, 0);
  const bool is_long = std::getenv("SOAK_BENCH_SESSIONS") != nullptr;
  EXPECT_GT(share, is_long ? 0.93 : 0.85) << what;
  if (!is_long) return;
  EXPECT_LT(share, 0.97) << what;
  // The bias of a gyro, which wanders from face to face, on its own.
  int held = 0;
  int biases = 0;
  for (const char* name : {"gyro_x bias", "gyro_y bias", "gyro_z bias"}) {
    held += shares.inside.at(name);
    biases += shares.tried.at(name);
  }
  std::printf("%s: gyros' bias %d of %d\n", what, held, biases);
  EXPECT_GT(held, 0.92 * biases) << what;
}

/// `record` makes a session from a truth, options and a seed. The circumstances differ from session to session.
template <class Record>
void judge_coverage(const char* what, const Record& record) {
  Shares shares;
  int failed = 0;
  for (int n = 0; n < sessions(); ++n) {
    base::Random random(static_cast<std::uint64_t>(n), 99);
    HandTruth truth;
    const auto perturb = [&](test::Matrix& gain, double sigma, bool triangular) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          if (!triangular || j >= i) gain[i][j] += sigma * random.gaussian();
        }
      }
    };
    perturb(truth.accel_gain, 0.005, true);
    perturb(truth.gyro_gain, 0.01, false);
    for (double& b : truth.accel_bias) b += 0.1 * random.gaussian();
    for (double& b : truth.gyro_bias) b += 0.01 * random.gaussian();
    HandOptions options;
    options.accel_noise = 0.01 * std::exp(random.uniform(-1.0, 1.5));
    options.gyro_noise = 0.001 * std::exp(random.uniform(-1.0, 2.0));
    options.gyro_walk = 1e-5 * std::exp(random.uniform(-1.5, 1.5));
    options.wobble_rad = random.uniform(0.0, 0.25);
    options.return_rad = random.uniform(0.001, 0.006);
    const auto model = fit(record(truth, options, 1000 + static_cast<std::uint64_t>(n)), options);
    if (!model) {
      std::printf("%s, session %d: %s\n", what, n, model.error().message.c_str());
      ++failed;
      continue;
    }
    for (const auto& [name, error] : errors_over_ci95(*model, truth)) {
      ++shares.tried[name];
      shares.inside[name] += std::abs(error) <= 1.0 ? 1 : 0;
    }
  }
  print_and_judge(what, shares, failed);
}

TEST(BenchCoverage, OfSessionsInManyAttitudes) {
  judge_coverage("24 attitudes", [](const HandTruth& truth, const HandOptions& options, std::uint64_t seed) {
    return many_attitudes(truth, options, seed);
  });
}

TEST(BenchCoverage, OfSessionsOnFacesAndEdgesWithTurns) {
  SOAK_LONG_TEST();
  judge_coverage("faces, edges, turns", [](const HandTruth& truth, const HandOptions& options, std::uint64_t seed) {
    return ferraris(truth, options, seed, false);
  });
}

TEST(BenchCoverage, OfSessionsOnNamedFacesWithTurns) {
  SOAK_LONG_TEST();
  judge_coverage("named faces, turns", [](const HandTruth& truth, const HandOptions& options, std::uint64_t seed) {
    return ferraris(truth, options, seed, true);
  });
}

}  // namespace
}  // namespace soak::calib
