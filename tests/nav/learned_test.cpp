// SPDX-License-Identifier: Apache-2.0
// What a filter's errors teach: errors that are known functions of the inputs, errors that nothing foretells.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "base/random.h"
#include "base/units.h"
#include "nav/learned/anfis_pipeline.h"
#include "nav/outages/outage_runner.h"
#include "nav/scenario/simulated_errors.h"
#include "nav/scenario/trajectory.h"
#include "tests/long_tests.h"

namespace soak::nav {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;

using ErrorLaw = std::function<ErrorOutputs(const ErrorInputs&, base::Random&)>;

/// Outages of 30 s on straight ways of any heading, with errors by a law.
std::vector<ErrorWindow> made_windows(std::size_t count, std::uint64_t seed, const ErrorLaw& law) {
  base::Random random(seed);
  std::vector<ErrorWindow> windows;
  for (std::size_t w = 0; w < count; ++w) {
    ErrorWindow window{30.0 * static_cast<double>(w), {}};
    const double heading_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
    for (int t = 1; t <= 30; ++t) {
      ErrorRow row{window.begin_s + t, {}, {}};
      for (double& input : row.inputs) input = 0.1 * random.gaussian();
      row.inputs[0] = t;
      row.inputs[9] = std::sin(heading_rad);
      row.inputs[10] = std::cos(heading_rad);
      row.error = law(row.inputs, random);
      window.rows.push_back(row);
    }
    windows.push_back(window);
  }
  return windows;
}

/// Of a constant acceleration to the right of the vehicle, 0.05 m/s²: ½ a t² and a t.
ErrorOutputs pushed_right(const ErrorInputs& inputs, base::Random& /*random*/) {
  const double t_s = inputs[0];
  const Vector3d right(inputs[10], -inputs[9], 0.0);
  ErrorOutputs error;
  error << 0.025 * t_s * t_s * right, 0.05 * t_s * right;
  error(2) = 0.01 * t_s * t_s;
  error(5) = 0.02 * t_s;
  return error;
}

ErrorOutputs noise(const ErrorInputs& inputs, base::Random& random) {
  ErrorOutputs error;
  for (double& value : error) value = inputs[0] * random.gaussian();
  return error;
}

ErrorModel learnt_from(const std::vector<ErrorWindow>& windows) {
  const auto model = learn_errors(windows);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

const ErrorModel& model_of_pushed_right() {
  static const ErrorModel model = learnt_from(made_windows(60, 1, pushed_right));
  return model;
}

FollowingErrorModel following(const ErrorModel& model, const std::vector<ErrorWindow>& followed) {
  auto follower = FollowingErrorModel::of(model, 30.0);
  EXPECT_TRUE(follower);
  for (const ErrorWindow& window : followed) follower->follow(window);
  return *std::move(follower);
}

TEST(ErrorModel, FindsAnErrorThatIsAFunctionOfTheInputs) {
  const FollowingErrorModel follower = following(model_of_pushed_right(), made_windows(8, 2, pushed_right));
  double left = 0.0;
  double all = 0.0;
  for (const ErrorWindow& fresh : made_windows(20, 3, pushed_right)) {
    for (const ErrorRow& row : fresh.rows) {
      left += (row.error - follower.expected(row.inputs).error).head<3>().squaredNorm();
      all += row.error.head<3>().squaredNorm();
    }
  }
  for (std::size_t k = 0; k < kErrorOutputs; ++k) EXPECT_TRUE(follower.carries(k)) << k;
  EXPECT_LT(std::sqrt(left / all), 0.2);
}

TEST(ErrorModel, DoesNotBelieveWhatItLearntFromNoise) {
  SOAK_LONG_TEST();
  int believed = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ErrorModel model = learnt_from(made_windows(20, 1000 * seed, noise));
    for (std::uint64_t drive = 1; drive <= 10; ++drive) {
      const FollowingErrorModel follower = following(model, made_windows(12, 1000 * seed + drive, noise));
      for (const std::size_t k : {0, 2, 3, 5}) believed += follower.carries(k) ? 1 : 0;
      const ErrorInputs inputs = made_windows(1, 1000 * seed + 500, noise).front().rows.back().inputs;
      for (std::size_t k = 0; k < kErrorOutputs; ++k) {
        if (follower.carries(k)) continue;
        const auto at = static_cast<Eigen::Index>(k);
        EXPECT_EQ(follower.expected(inputs).error(at), 0.0);
        EXPECT_EQ(follower.expected(inputs).sigma(at), kUnknownError);
      }
    }
  }
  // Corrections learnt from noise do harm: they pass more rarely than those that do neither (next test).
  EXPECT_LE(believed, 2);
}

TEST(ErrorModel, BelievesWhatNeitherHelpsNorHarmsAsRarelyAsTwoStandardErrorsAllow) {
  // Half of the expected error e, and noise n: |e/2 + n| less |e/2 + n - e| has a distribution that is even about 0.
  const ErrorLaw half = [](const ErrorInputs& inputs, base::Random& random) {
    return ErrorOutputs(0.5 * pushed_right(inputs, random) + 0.5 * noise(inputs, random));
  };
  int believed = 0;
  for (std::uint64_t drive = 1; drive <= 50; ++drive) {
    const FollowingErrorModel follower = following(model_of_pushed_right(), made_windows(12, 2000 + drive, half));
    for (const std::size_t k : {0, 2, 3, 5}) believed += follower.carries(k) ? 1 : 0;
  }
  // Student's t with 11 degrees of freedom is above 2 in 3.5 %, 7 of 200 (standard deviation 2.6), and above 1 in 17 %,
  // 34 of 200 (5.3).
  EXPECT_LE(believed, 17);
  EXPECT_GE(believed, 1);
}

TEST(ErrorModel, NeedsFourOutagesToBelieve) {
  EXPECT_FALSE(following(model_of_pushed_right(), made_windows(3, 2, pushed_right)).carries(0));
  EXPECT_TRUE(following(model_of_pushed_right(), made_windows(4, 2, pushed_right)).carries(0));
}

TEST(ErrorModel, FollowsAnErrorThatIsNotTheOneLearntButSlowly) {
  const ErrorLaw twice = [](const ErrorInputs& inputs, base::Random& random) {
    return ErrorOutputs(2.0 * pushed_right(inputs, random));
  };
  const auto left_after = [&](std::size_t outages) {
    const FollowingErrorModel follower = following(model_of_pushed_right(), made_windows(outages, 2, twice));
    double with = 0.0;
    double without = 0.0;
    for (const ErrorWindow& fresh : made_windows(20, 3, twice)) {
      const ErrorRow& row = fresh.rows.back();
      with += (row.error - follower.expected(row.inputs).error).head<2>().norm();
      without += (row.error - expected_error(model_of_pushed_right(), row.inputs).error).head<2>().norm();
    }
    return with / without;
  };
  // A drive of ten minutes holds 18 outages. With a window of 30 s nearly all would be learnt after 8.
  EXPECT_LT(left_after(8), 0.95);
  EXPECT_GT(left_after(8), 0.5);
  EXPECT_LT(left_after(18), 0.87);
  EXPECT_LT(left_after(40), 0.72);
}

TEST(ErrorGrowth, FitsErrorsOfThePositionByTheSquareOfTheTime) {
  base::Random random(5);
  ErrorGrowth growth;
  EXPECT_EQ(growth.sigma_after(10.0), ErrorOutputs::Zero());
  for (int i = 0; i < 4000; ++i) {
    const double t_s = random.uniform(1.0, 30.0);
    ErrorOutputs error;
    for (Eigen::Index k = 0; k < 3; ++k) error(k) = 0.02 * t_s * t_s * random.gaussian();
    for (Eigen::Index k = 3; k < 6; ++k) error(k) = 0.1 * t_s * random.gaussian();
    growth.add(t_s, error);
  }
  // The largest times count most: some 800 of 4000 errors, a standard deviation known to 2.5 %.
  EXPECT_NEAR(growth.sigma_after(20.0)(1), 8.0, 0.1 * 8.0);
  EXPECT_NEAR(growth.sigma_after(20.0)(4), 2.0, 0.1 * 2.0);
}

constexpr double kUpBias_mps2 = 0.05;

/// A straight way at 12 m/s with an accelerometer that reads too much upwards.
Drive lifted(std::uint64_t seed) {
  const std::vector<Maneuver> maneuvers = {{15}, {10, 12.0}, {275, 12.0}};
  Drive drive =
      Trajectory({51.08 * kRadPerDeg, -114.13 * kRadPerDeg, 1045.0}, 0.3 * static_cast<double>(seed), maneuvers)
          .drive(50, 50, Vector3d::Zero());
  drive.name = "lifted";
  const UnitErrors errors{"", {0.0, 0.0, 100.0, 0.005 * kRadPerDeg}, {0.0, 0.0, 100.0, 0.002}};
  add_errors(drive.imu, errors, {}, {}, seed);
  for (ImuSample& sample : drive.imu) sample.force_mps2.z() += kUpBias_mps2;
  drive.gnss = simulated_fixes(drive.truth, 1, {}, seed);
  return drive;
}

/// A filter that takes its accelerometers for free of bias.
FilterPipeline trusting(double gate_probability = 0.0) {
  FilterPipeline parts{"trusting", "", {}, {}, {}};
  parts.filter.sensors = same_for_axes({0.02 * kRadPerDeg, {0.01 * kRadPerDeg}}, {0.05, {1e-6}});
  parts.filter.gate_probability = gate_probability;
  return parts;
}

std::vector<ErrorWindow> windows_of(const Drive& drive) {
  const auto setup = set_up(trusting(), drive);
  EXPECT_TRUE(setup);
  return error_windows(*setup, successive_begins(*setup, 30.0, 30.0), 30.0);
}

TEST(ErrorWindows, OfABiasUpwardsHoldItsFreeFall) {
  const auto windows = windows_of(lifted(1));
  ASSERT_EQ(windows.size(), 8u);
  for (const ErrorWindow& window : windows) {
    ASSERT_EQ(window.rows.size(), 30u);
    const ErrorRow& last = window.rows.back();
    EXPECT_NEAR(last.inputs[0], 30.0, 1e-6);
    EXPECT_NEAR(last.inputs[3], 9.81 + kUpBias_mps2, 0.02);
    EXPECT_NEAR(std::atan2(last.inputs[9], last.inputs[10]), 0.3, 0.02);
    // ½ b t² is 22.5 m; with fixes at 1 Hz a velocity of b times a second stays, 1.5 m.
    EXPECT_NEAR(last.error(2), 0.5 * kUpBias_mps2 * 900.0, 3.0);
    EXPECT_NEAR(last.error(5), kUpBias_mps2 * 30.0, 0.1);
  }
  EXPECT_NEAR(windows.back().rows.back().t_s, 300.0, 1e-6);
}

TEST(ErrorWindows, CountTheTimeFromTheLastFixAsARealOutageDoes) {
  const auto setup = set_up(trusting(), lifted(1));
  ASSERT_TRUE(setup);
  const std::vector<double> begins_s = {100.4};
  const auto windows = error_windows(*setup, begins_s, 10.0);
  ASSERT_EQ(windows.front().rows.size(), 10u);
  EXPECT_NEAR(windows.front().rows.front().inputs[0], 1.0, 1e-6);
  EXPECT_NEAR(windows.front().rows.back().inputs[0], 10.0, 1e-6);
}

const ErrorModel& model_of_lifted() {
  static const ErrorModel model = [] {
    std::vector<ErrorWindow> learnt;
    for (const std::uint64_t seed : {2, 3, 4}) {
      for (ErrorWindow& window : windows_of(lifted(seed))) learnt.push_back(std::move(window));
    }
    return learnt_from(learnt);
  }();
  return model;
}

TEST(AnfisPipelines, CorrectAnErrorAlsoWhereTheFilterLeavesOutliersOut) {
  const FilterPipeline gated = trusting(FilterOptions{}.gate_probability);
  const std::vector<Pipeline> pipelines = {filter_pipeline(gated), anfis_updates(gated, model_of_lifted())};
  const auto result = run_outage(lifted(5), {250.0, 280.0}, pipelines);
  ASSERT_TRUE(result);
  const double alone_m = std::abs(result->pipelines[0].position_final_m.z());
  EXPECT_GT(alone_m, 15.0);
  EXPECT_LT(std::abs(result->pipelines[1].position_final_m.z()), 0.25 * alone_m);
}

TEST(AnfisPipelines, CorrectAnErrorThatEveryOutageShows) {
  const ErrorModel& model = model_of_lifted();
  const std::vector<Pipeline> pipelines = {filter_pipeline(trusting()), anfis_position(trusting(), model),
                                           anfis_updates(trusting(), model)};
  const auto result = run_outage(lifted(5), {250.0, 280.0}, pipelines);
  ASSERT_TRUE(result);
  const double alone_m = std::abs(result->pipelines[0].position_final_m.z());
  EXPECT_GT(alone_m, 15.0);
  for (const std::size_t p : {1, 2}) {
    EXPECT_LT(std::abs(result->pipelines[p].position_final_m.z()), 0.25 * alone_m) << pipelines[p].name;
    EXPECT_LT(result->pipelines[p].horizontal_final_m, 1.5 * result->pipelines[0].horizontal_final_m + 0.5);
  }
}

TEST(AnfisPipelines, AFixOfTheHeightLeavesEastAndNorthWhereTheseAreNotBelieved) {
  base::Random random(9);
  std::vector<ErrorWindow> learnt;
  for (const std::uint64_t seed : {2, 3, 4}) {
    for (ErrorWindow& window : windows_of(lifted(seed))) {
      for (ErrorRow& row : window.rows) {
        for (const Eigen::Index k : {0, 1, 3, 4}) row.error(k) = 50.0 + 10.0 * random.gaussian();
      }
      learnt.push_back(std::move(window));
    }
  }
  const std::vector<Pipeline> pipelines = {filter_pipeline(trusting()), anfis_updates(trusting(), learnt_from(learnt))};
  const auto result = run_outage(lifted(5), {250.0, 280.0}, pipelines);
  ASSERT_TRUE(result);
  const Vector3d& alone_m = result->pipelines[0].position_final_m;
  const Vector3d& helped_m = result->pipelines[1].position_final_m;
  EXPECT_LT(std::abs(helped_m.z()), 0.25 * std::abs(alone_m.z()));
  EXPECT_LT((helped_m - alone_m).head<2>().norm(), 1e-5);
}

TEST(AnfisPipelines, AreTheFilterAloneWhereTheirModelDoesNotCarry) {
  const ErrorModel model = learnt_from(made_windows(30, 7, [](const ErrorInputs& inputs, base::Random& random) {
    return ErrorOutputs(10.0 * noise(inputs, random) + ErrorOutputs::Constant(50.0));
  }));
  const std::vector<Pipeline> pipelines = {filter_pipeline(trusting()), anfis_position(trusting(), model),
                                           anfis_updates(trusting(), model)};
  const auto result = run_outage(lifted(5), {250.0, 280.0}, pipelines);
  ASSERT_TRUE(result);
  for (const std::size_t p : {1, 2}) {
    EXPECT_LT((result->pipelines[p].position_final_m - result->pipelines[0].position_final_m).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace soak::nav
