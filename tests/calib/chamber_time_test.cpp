// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/chamber_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/random.h"
#include "base/statistics.h"
#include "calib/judge/detail/schedule.h"
#include "calib/judge/detail/subsampling.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

using Truth = double (*)(double);

constexpr double kNoise = 0.002;
constexpr double kRunSigma = 0.02;
constexpr int kPlateaus = 21;

double level_c(int plateau) { return -30.0 + 5.0 * plateau; }

double smooth_arctangent(double temp_c) { return 0.28 * std::atan((temp_c - 15.0) / 25.0); }
/// A feature too narrow for plateaus 10 K apart, between two of which it lies.
double narrow(double temp_c) {
  return smooth_arctangent(temp_c) + 0.1 * std::exp(-0.5 * std::pow((temp_c - 35.0) / 3.0, 2));
}

/// Rows of a campaign of one sensor, one row per run and plateau on the way up.
PlacedRows campaign(Truth truth, int runs, std::uint64_t seed) {
  PlacedRows rows;
  base::Random random(seed, 11);
  for (int run = 0; run < runs; ++run) {
    rows.data.runs.push_back("R" + std::to_string(run + 1));
    const double offset = kRunSigma * random.gaussian();
    for (int p = 0; p < kPlateaus; ++p) {
      const double temp_c = level_c(p) + 0.2 * random.gaussian();
      rows.data.rows.push_back(
          {run, run, Sweep::up, 1800.0 * p, temp_c, truth(temp_c) + offset + kNoise * random.gaussian(), kNoise});
      rows.place.push_back(p);
    }
  }
  rows.components = *estimate_variance_components(rows.data);
  rows.structure = {Family::anfis, 6, anfis::Shape::gaussian};
  return rows;
}

std::vector<bool> every_plateau(const PlacedRows& rows, int step) {
  const std::vector<bool> kept = every(kPlateaus, step);
  std::vector<bool> keep;
  for (const int place : rows.place) keep.push_back(kept[static_cast<std::size_t>(place)]);
  return keep;
}

/// Mean over all plateaus of the squared error of a curve against the truth, its mean error removed.
double squared_shape_error(const Curve& curve, Truth truth) {
  double sum = 0.0;
  double squares = 0.0;
  for (int p = 0; p < kPlateaus; ++p) {
    const double error = evaluate(curve, level_c(p)) - truth(level_c(p));
    sum += error / kPlateaus;
    squares += error * error / kPlateaus;
  }
  return squares - sum * sum;
}

/// The expected squared error of campaigns of that kind: a mean over new ones, which know nothing of any sub-sampling.
double actual_error(Truth truth, int runs, int step) {
  constexpr int kCampaigns = 60;
  double mean = 0.0;
  for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
    const PlacedRows rows = campaign(truth, runs, 10000 + seed);
    anfis::TrainingData data = training_data(rows.data, rows.components, every_plateau(rows, step));
    const auto fit = fit_part(data, rows.structure);
    if (!fit) throw std::runtime_error(fit.error().message);
    mean += squared_shape_error(fit->curve, truth) / kCampaigns;
  }
  return mean;
}

struct Coverage {
  double covered = 0.0;  ///< share of campaigns whose interval holds the actual error
  double ratio = 0.0;    ///< mean prediction / actual
};

Coverage coverage(Truth truth, int all, int runs, int step) {
  constexpr int kCampaigns = 40;
  const double actual = actual_error(truth, runs, step);
  Coverage result;
  for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
    const PlacedRows rows = campaign(truth, all, seed);
    const SquaredError error = subsampled_error(rows, every_plateau(rows, step), runs, seed).value();
    const double half = base::student_t_two_sided(0.95, all - 1.0) * error.standard_error;
    result.covered += std::abs(error.value - actual) <= half ? 1.0 / kCampaigns : 0.0;
    result.ratio += error.value / actual / kCampaigns;
  }
  return result;
}

TEST(ChamberTime, PredictsTheErrorOfShorterCampaignsWithinItsInterval) {
  // 60 campaigns give the actual squared error to √(2 / (60 · 6)) = 7 % (χ² of at least 6 parameters), the mean of 40
  // predictions, each good to 40 %, scatters by 6 %: 20 % is more than twice the two together. Of 40 intervals of 95 %
  // at least 34 cover with a probability of 0.996.
  for (const Truth truth : {&smooth_arctangent, &narrow}) {
    for (const auto& [runs, step] : {std::pair(2, 1), std::pair(4, 2), std::pair(6, 3)}) {
      const Coverage result = coverage(truth, 12, runs, step);
      EXPECT_GE(result.covered, 0.849) << runs << " runs, every " << step;
      EXPECT_NEAR(result.ratio, 1.0, 0.2) << runs << " runs, every " << step;
    }
  }
}

TEST(ChamberTime, IntervalHoldsWithTheFewestRuns) {
  const Coverage result = coverage(smooth_arctangent, 4, 2, 2);
  EXPECT_GE(result.covered, 0.849);
}

double predicted(Truth truth, int runs, int step) {
  const PlacedRows rows = campaign(truth, 12, 5);
  return std::sqrt(subsampled_error(rows, every_plateau(rows, step), runs, 1).value().value);
}

TEST(ChamberTime, TellsASmoothCurveFromANarrowFeature) {
  // Half the plateaus of twice the runs hold as many rows of a smooth_arctangent curve; a feature of 0.1 between them
  // is missed.
  EXPECT_LT(predicted(smooth_arctangent, 8, 2), kNoise / 2.0);
  EXPECT_GT(predicted(narrow, 8, 2), 5.0 * kNoise);
}

TEST(ChamberTime, RunsDoNotMendWhatPlateausMiss) {
  EXPECT_NEAR(predicted(narrow, 8, 2) / predicted(narrow, 2, 2), 1.0, 0.15);
  EXPECT_LT(predicted(smooth_arctangent, 8, 1), 0.7 * predicted(smooth_arctangent, 2, 1));
}

TEST(ChamberTime, NeedsTwoRunsThatWereLeftOut) {
  const PlacedRows rows = campaign(smooth_arctangent, 4, 1);
  EXPECT_TRUE(subsampled_error(rows, every_plateau(rows, 1), 2, 1));
  EXPECT_FALSE(subsampled_error(rows, every_plateau(rows, 1), 3, 1));
}

TEST(ChamberTime, TrendIsTheLineThroughExactPointsAndNeverNegative) {
  const auto at = [](std::vector<std::pair<int, double>> points, int runs) {
    std::vector<TrendPoint> list;
    for (const auto& [n, value] : points) list.push_back({n, {value, 0.1, 0.0}});
    return extrapolated_error(list, runs).value().value;
  };
  EXPECT_NEAR(at({{1, 5.0}, {2, 3.0}, {4, 2.0}}, 8), 1.5, 1e-9);  // 1 + 4 / n
  EXPECT_NEAR(at({{1, 4.0}, {2, 1.0}}, 8), 3.6 / 8.0, 1e-9);      // without floor: b = (4 + ½) / (1 + ¼)
  EXPECT_NEAR(at({{1, 2.0}, {2, 3.0}, {4, 4.0}}, 8), 3.0, 1e-9);  // rising: the mean
  EXPECT_NEAR(at({{1, -2.0}, {2, -3.0}}, 8), 0.0, 1e-9);
  EXPECT_FALSE(extrapolated_error({}, 8));
}

/// Visits at 0, 10, 20, 10 °C of 600 s; ways of 100, 200 and 300 s; 50 s before the first.
RunSchedule made_up_run() {
  return {0.0,
          {{50.0, 650.0, 0.0, Sweep::up},
           {750.0, 1350.0, 10.0, Sweep::up},
           {1550.0, 2150.0, 20.0, Sweep::up},
           {2450.0, 3050.0, 10.0, Sweep::down}}};
}

TEST(ChamberTime, HoursOfAWholeRunAreThoseRecorded) {
  const RunHours hours = run_hours(made_up_run(), {true, true, true, true});
  EXPECT_NEAR(hours.most, 3050.0 / 3600.0, 1e-12);
  EXPECT_NEAR(hours.least, 3050.0 / 3600.0, 1e-12);
}

TEST(ChamberTime, ALeftOutPlateauSavesItsStayAndAtMostTheShorterWays) {
  // 50 + 600 + way + 600 with the way from 0 to 20 °C between 200 and 100 + 200 s; nothing after the last kept visit.
  const RunHours hours = run_hours(made_up_run(), {true, false, true, false});
  EXPECT_NEAR(hours.most, 1550.0 / 3600.0, 1e-12);
  EXPECT_NEAR(hours.least, 1450.0 / 3600.0, 1e-12);
}

TEST(ChamberTime, ASweepBeginsAtThePlateauItComesFrom) {
  const RunSchedule run = made_up_run();
  const std::vector<double> plateaus = set_points({run});
  EXPECT_EQ(plateaus, (std::vector<double>{0.0, 10.0, 20.0}));
  const std::vector<bool> all = every(3, 1);
  EXPECT_EQ(kept_visits(run, plateaus, all, Sweeps::down), (std::vector<bool>{false, false, true, true}));
  EXPECT_EQ(kept_visits(run, plateaus, all, Sweeps::up), (std::vector<bool>{true, true, true, false}));
  // 50 s before, 600 + 300 + 600: the way up is not driven.
  EXPECT_NEAR(run_hours(run, {false, false, true, true}).most, 1550.0 / 3600.0, 1e-12);
}

TEST(ChamberTime, EveryNthPlateauKeepsBothEnds) {
  EXPECT_EQ(every(6, 2), (std::vector<bool>{true, false, true, false, true, true}));
  EXPECT_EQ(every(4, 3), (std::vector<bool>{true, false, false, true}));
}

/// A run with six positions of ten minutes at every 5 K up (and down), gyro x following the truth.
RunInput recorded_run(int number, Truth truth, bool both_ways) {
  RunInput run;
  run.label = "R" + std::to_string(number);
  run.run_id = "id-" + run.label;
  base::Random random(static_cast<std::uint64_t>(number), 3);
  const double offset = kRunSigma * random.gaussian();
  double t_s = 0.0;
  for (int visit = 0; visit < (both_ways ? 2 * kPlateaus - 1 : kPlateaus); ++visit) {
    const bool up = visit < kPlateaus;
    const double temp_c = level_c(up ? visit : 2 * kPlateaus - 2 - visit) + 0.2 * random.gaussian();
    t_s += visit > 0 ? 1500.0 : 0.0;
    for (const auto name : kSixPositionLabels) {
      Segment segment;
      segment.key = {run.run_id, "U", visit, std::string(name), 0};
      segment.plateau_c = level_c(up ? visit : 2 * kPlateaus - 2 - visit);
      segment.sweep = up ? Sweep::up : Sweep::down;
      segment.position = *position_named(name);
      segment.t_start_s = t_s;
      segment.t_end_s = t_s += 600.0;
      segment.temp_c = temp_c;
      segment.sensor_temp_c.fill(temp_c);
      const double mean = truth(temp_c) + offset + kNoise * random.gaussian();
      segment.sensor[index_of(Sensor::gyro_x)] = {600, mean, 600 * kNoise * kNoise, kNoise};
      run.segments.push_back(segment);
    }
  }
  return run;
}

/// The study of a campaign whose fit led to an ANFIS of six rules.
ChamberTime study(Truth truth, int runs, bool both_ways = false) {
  UnitInput input;
  for (int r = 1; r <= runs; ++r) input.runs.push_back(recorded_run(r, truth, both_ways));
  const auto rows = make_rows(input);
  if (!rows) throw std::runtime_error(rows.error().message);
  SensorFits fits;
  fits[0].emplace();
  fits[0]->bias.rules = 6;
  fits[0]->bias.membership = "gaussian";
  return study_chamber_time(input, *rows, fits);
}

/// Whether some option with half the plateaus or fewer is expected to keep the shape error within 10 % of the whole
/// campaign's.
bool can_skip_plateaus(const ChamberTime& study) {
  const double whole = study.options.back().sensors[0]->rmse_shape;
  return std::ranges::any_of(study.options, [whole](const ChamberTimeOption& option) {
    return option.plateau_step > 1 && option.sensors[0]->rmse_shape <= 1.1 * whole;
  });
}

TEST(ChamberTime, PlateausCanBeLeftOutWhereTheCurveIsSmoothOnly) {
  const ChamberTime of_smooth = study(smooth_arctangent, 12);
  ASSERT_TRUE(of_smooth.recommended) << of_smooth.reason;
  EXPECT_LT(of_smooth.options[*of_smooth.recommended].hours, 0.6 * of_smooth.hours);
  EXPECT_TRUE(can_skip_plateaus(of_smooth));
  EXPECT_FALSE(can_skip_plateaus(study(narrow, 12)));
}

TEST(ChamberTime, RecommendedIsTheShortestThatMayBe) {
  const ChamberTime result = study(smooth_arctangent, 12);
  ASSERT_TRUE(result.recommended);
  const double whole = result.options.back().sensors[0]->rmse_shape;
  for (std::size_t i = 0; i < *result.recommended; ++i) {
    const ChamberTimeOption& option = result.options[i];
    EXPECT_TRUE(option.runs < 3 || option.sensors[0]->rmse_shape_high > 1.1 * whole);
  }
  EXPECT_GE(result.options[*result.recommended].runs, 3);
  EXPECT_LE(result.options[*result.recommended].sensors[0]->rmse_shape_high, 1.1 * whole);
}

TEST(ChamberTime, OptionsRiseInHoursUpToTheWholeCampaign) {
  const ChamberTime result = study(smooth_arctangent, 8, true);
  // 41 visits of an hour and 40 ways of 25 minutes, eight times.
  EXPECT_NEAR(result.hours, 8.0 * (41.0 + 40.0 * 1500.0 / 3600.0), 1e-9);
  EXPECT_TRUE(std::ranges::is_sorted(result.options, {}, &ChamberTimeOption::hours));
  EXPECT_EQ(result.options.back().runs, 8);
  EXPECT_EQ(result.options.back().plateau_step, 1);
  EXPECT_EQ(result.options.back().sweeps, Sweeps::both);
  EXPECT_NEAR(result.options.back().hours, result.hours, 1e-9);
  for (const ChamberTimeOption& option : result.options) {
    EXPECT_LE(option.hours_at_least, option.hours);
    EXPECT_EQ(option.measured, option.runs < 8);
    EXPECT_TRUE(option.sensors[0]);
    EXPECT_FALSE(option.sensors[1]);
    EXPECT_EQ(option.plateaus_c.front(), -30.0);
    EXPECT_EQ(option.plateaus_c.back(), 70.0);
  }
  const auto one_way = std::ranges::count(result.options, Sweeps::down, &ChamberTimeOption::sweeps);
  EXPECT_GT(one_way, 0);
}

TEST(ChamberTime, ShapeErrorHoldsTheScatterOfSingleEstimates) {
  const ChamberTime result = study(smooth_arctangent, 12);
  const ExpectedError& whole = *result.options.back().sensors[0];
  // The six positions of a visit average their noise: the bias of gyro x comes from its own up/down pair at worst.
  const double scatter = std::sqrt(whole.rmse_shape * whole.rmse_shape - whole.error_rms * whole.error_rms);
  EXPECT_GT(scatter, kNoise / std::sqrt(6.0) * 0.8);
  EXPECT_LT(scatter, kNoise / std::sqrt(2.0) * 1.6);
  EXPECT_LE(whole.error_low, whole.error_rms);
  EXPECT_GE(whole.error_high, whole.error_rms);
}

TEST(ChamberTime, SaysThatThreeRunsAreTooFew) {
  const ChamberTime result = study(smooth_arctangent, 3);
  EXPECT_TRUE(result.options.empty());
  EXPECT_FALSE(result.recommended);
  EXPECT_TRUE(base::mentions(result.reason, {"3", "4"}));
}

TEST(ChamberTime, TheSameInputGivesTheSameNumbers) {
  const ChamberTime a = study(smooth_arctangent, 5);
  const ChamberTime b = study(smooth_arctangent, 5);
  ASSERT_EQ(a.options.size(), b.options.size());
  for (std::size_t i = 0; i < a.options.size(); ++i) {
    EXPECT_EQ(a.options[i].sensors[0]->error_rms, b.options[i].sensors[0]->error_rms);
  }
}

}  // namespace
}  // namespace soak::calib
