// SPDX-License-Identifier: Apache-2.0
// Terms that `calib/gap` found with its regressors, evaluated by mechanism: two codes that must mean the same.
#include "calib/forward/mechanisms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/forward/simulation.h"
#include "calib/gap/base/campaign_model.h"
#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::forward {
namespace {

using gap::LoggedCampaign;
namespace made_up = gap::made_up;

/// The effect with its first or last shape and parameters of a test's own, as `gap accept` would keep it.
ModelTerm term_of(const LoggedCampaign& campaign, const gap::Effect& effect, const gap::RegressorInputs& inputs,
                  const gap::Candidate& candidate) {
  gap::GapReport report;
  report.conclusion = gap::Conclusion::named;
  gap::NamedEffect named;
  named.effect = &effect;
  named.candidate = candidate;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const Eigen::Index count = candidate.columns[s].cols();
    if (count == 0) continue;
    named.sensors.push_back(sensor);
    named.parameters[s] = Eigen::VectorXd::LinSpaced(count, 1.0, 2.0);
    if (!candidate.shared) named.parameters[s] *= 1.0 + 0.1 * static_cast<double>(s);
    named.covariance[s] = Eigen::MatrixXd::Identity(count, count);
    named.meaning[s] = effect.meaning(inputs, candidate, sensor);
  }
  report.effects.push_back(named);
  const auto accepted = gap::accepted_terms(campaign, report, {});
  EXPECT_TRUE(accepted) << effect.name;
  return accepted ? accepted->front() : ModelTerm{};
}

/// Largest difference between what regressors and mechanism say at the blocks, each less its mean over the run (offsets
/// are the runs' own), over the largest value.
double disagreement(const LoggedCampaign& campaign, const gap::Observations& rows, const gap::Candidate& candidate,
                    const ModelTerm& term) {
  double worst = 0.0;
  double largest = 0.0;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (candidate.columns[s].cols() == 0) continue;
    Eigen::VectorXd parameters = Eigen::VectorXd::LinSpaced(candidate.columns[s].cols(), 1.0, 2.0);
    if (!candidate.shared) parameters *= 1.0 + 0.1 * static_cast<double>(s);
    const Eigen::VectorXd expected = candidate.columns[s] * parameters;
    std::size_t i = 0;
    for (const gap::LoggedRun& run : campaign.runs) {
      const std::vector<ModelTerm> terms = {term};
      const Mechanisms mechanisms(terms, run, 1);
      EXPECT_TRUE(mechanisms.not_evaluated().empty());
      std::vector<double> off;
      for (const Segment& segment : run.run.segments) {
        for (const Block& block : segment.blocks) {
          const Moment moment{&segment, block.t_s, 0.5 * block.duration_s, block.temp_c};
          off.push_back(mechanisms.contribution(sensor, moment) - expected(static_cast<Eigen::Index>(i)));
          largest = std::max(largest, std::abs(expected(static_cast<Eigen::Index>(i))));
          ++i;
        }
      }
      double mean = 0.0;
      for (const double value : off) mean += value / static_cast<double>(off.size());
      for (const double value : off) worst = std::max(worst, std::abs(value - mean));
    }
    EXPECT_EQ(i, rows.rows.size());
  }
  return worst / largest;
}

TEST(Mechanisms, SayWhatTheRegressorsSaidThatFoundThem) {
  const LoggedCampaign campaign = made_up::campaign({}, made_up::nothing());
  const gap::Observations rows = gap::observe(campaign);
  const gap::TemperatureHistory history(campaign, rows);
  const gap::CampaignModel model(rows, history);
  int compared = 0;
  for (const gap::Effect& effect : gap::library()) {
    // A lag moves the temperature that curves are read at: LagsMoveTemperatures. Tilts count about their mean.
    if (effect.name == "sensor_lag" || effect.name == "fixture_tilt") continue;
    ASSERT_FALSE(effect.missing(model.regressor_inputs())) << effect.name;
    for (const gap::Candidate& candidate : effect.candidates(model.regressor_inputs())) {
      const ModelTerm term = term_of(campaign, effect, model.regressor_inputs(), candidate);
      EXPECT_LT(disagreement(campaign, rows, candidate, term), 2e-3) << effect.name << ' ' << candidate.shape;
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

TEST(Mechanisms, TiltsOfTheRunsCountAboutTheirMean) {
  const LoggedCampaign campaign = made_up::campaign({.runs = 3}, made_up::nothing());
  ModelTerm tilt;
  tilt.name = "fixture_tilt";
  tilt.parts = {{{Sensor::accel_x, Sensor::accel_y, Sensor::accel_z},
                 {{"z@R2", 0.003, "rad"}, {"z@R3", 0.006, "rad"}, {"z@R1", 0.0, "rad"}},
                 {}}};
  const std::vector<ModelTerm> terms = {tilt};
  const auto of_run = [&](std::size_t run) {
    const Mechanisms mechanisms(terms, campaign.runs[run], 1);
    const auto& segments = campaign.runs[run].run.segments;
    const auto up_y = std::find_if(segments.begin(), segments.end(),
                                   [](const Segment& segment) { return segment.position->label == "+Y"; });
    return mechanisms.contribution(Sensor::accel_x, {&*up_y, up_y->t_start_s, 0.0, 20.0});
  };
  // With +Y up a turn about z brings gravity into x.
  EXPECT_NEAR(of_run(1) - of_run(0), 9.81 * 0.003, 1e-9);
  EXPECT_NEAR(of_run(2) - of_run(0), 9.81 * 0.006, 1e-9);
  EXPECT_NEAR(of_run(0) + of_run(1) + of_run(2), 0.0, 1e-9);
}

TEST(Mechanisms, APastIsTakenOffAboutItsMeanAtEachTemperature) {
  LoggedCampaign campaign = made_up::campaign({.runs = 2}, made_up::nothing());
  const LoggedCampaign recorded = campaign;
  std::vector<ModelTerm> terms(1);
  terms[0].name = "thermal_hysteresis";
  terms[0].parts = {{{Sensor::gyro_x}, {{"amplitude", 1e-3, "rad/s"}, {"width_c", 6.0, "K"}}, {}, {}}};
  centre(campaign, terms);
  ASSERT_EQ(terms[0].parts[0].centre.size(), 7U);
  EXPECT_TRUE(subtract_terms(terms, campaign).empty());
  std::map<double, double> taken;
  double largest = 0.0;
  for (std::size_t r = 0; r < 2; ++r) {
    for (std::size_t k = 0; k < campaign.runs[r].run.segments.size(); ++k) {
      const Segment& before = recorded.runs[r].run.segments[k];
      for (std::size_t b = 0; b < before.blocks.size(); ++b) {
        const double off = before.blocks[b].sensor[0].mean - campaign.runs[r].run.segments[k].blocks[b].sensor[0].mean;
        taken[*before.plateau_c] += off;
        largest = std::max(largest, std::abs(off));
      }
    }
  }
  EXPECT_GT(largest, 5e-4);
  for (const auto& [set_c, sum] : taken) EXPECT_NEAR(sum / 72.0, 0.0, 2e-5) << set_c;
}

TEST(Mechanisms, LagsMoveTemperatures) {
  const LoggedCampaign campaign = made_up::campaign({}, made_up::nothing());
  const gap::Observations rows = gap::observe(campaign);
  const gap::TemperatureHistory history(campaign, rows);
  ModelTerm term;
  term.name = "sensor_lag";
  term.parts = {{{Sensor::gyro_x}, {{"factor", 0.8, "1"}, {"tau_s", 160.0, "s"}}, {}}};
  const std::vector<double> behind = history.lag(160.0);
  const std::vector<ModelTerm> terms = {term};
  const Mechanisms mechanisms(terms, campaign.runs.front(), 1);
  std::size_t i = 0;
  double largest = 0.0;
  for (const Segment& segment : campaign.runs.front().run.segments) {
    for (const Block& block : segment.blocks) {
      const Moment moment{&segment, block.t_s, 0.0, block.temp_c};
      EXPECT_NEAR(mechanisms.element_temp_c(Sensor::gyro_x, moment) - block.temp_c, 0.8 * behind[i], 1e-6);
      EXPECT_EQ(mechanisms.element_temp_c(Sensor::gyro_y, moment), block.temp_c);
      EXPECT_EQ(mechanisms.contribution(Sensor::gyro_x, moment), 0.0);
      largest = std::max(largest, std::abs(behind[i]));
      ++i;
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST(Mechanisms, SayWhyARunCannotBeEvaluated) {
  LoggedCampaign campaign = made_up::campaign({.runs = 1}, made_up::nothing());
  campaign.runs.front().log.supply_v.clear();
  ModelTerm supply;
  supply.name = "supply_sensitivity";
  supply.parts = {{{Sensor::gyro_x}, {{"per_v", 1.0, "rad/s/V"}, {"reference_v", 5.0, "V"}}, {}}};
  ModelTerm newer;
  newer.name = "magic";
  newer.parts = supply.parts;
  const auto not_evaluated = subtract_terms({supply, newer}, campaign);
  ASSERT_EQ(not_evaluated.size(), 2U);
  EXPECT_NE(not_evaluated[0].find("supply_sensitivity"), std::string::npos) << not_evaluated[0];
  EXPECT_NE(not_evaluated[1].find("magic"), std::string::npos) << not_evaluated[1];
}

TEST(Mechanisms, ABumpIsHighAtItsCentreAndHalfAsHighAWidthAway) {
  LoggedCampaign campaign = made_up::campaign({.runs = 1}, made_up::nothing());
  ModelTerm bump;
  bump.name = "narrow_bump";
  bump.parts = {{{Sensor::gyro_y}, {{"height", 2e-3, "rad/s"}, {"centre_c", 30.0, "degC"}, {"width_c", 3.0, "K"}}, {}}};
  const std::vector<ModelTerm> terms = {bump};
  const Mechanisms mechanisms(terms, campaign.runs.front(), 1);
  const Segment& segment = campaign.runs.front().run.segments.front();
  const auto at = [&](Sensor sensor, double temp_c) {
    return mechanisms.contribution(sensor, {&segment, 500.0, 0.0, temp_c});
  };
  EXPECT_NEAR(at(Sensor::gyro_y, 30.0), 2e-3, 1e-12);
  EXPECT_NEAR(at(Sensor::gyro_y, 33.0), 1e-3, 1e-12);
  EXPECT_NEAR(at(Sensor::gyro_y, 27.0), 1e-3, 1e-12);
  EXPECT_EQ(at(Sensor::gyro_z, 30.0), 0.0);
  // A search no longer sees it.
  const double before = campaign.runs.front().run.segments.front().blocks.front().sensor[1].mean;
  const double temp_c = segment.blocks.front().sensor_temp_c[1];
  EXPECT_TRUE(subtract_terms(terms, campaign).empty());
  EXPECT_NEAR(before - segment.blocks.front().sensor[1].mean, at(Sensor::gyro_y, temp_c), 1e-12);
}

TEST(Mechanisms, AgeingRunsThroughTheCalendar) {
  const LoggedCampaign campaign = made_up::campaign({.runs = 2}, made_up::nothing());
  ModelTerm aging;
  aging.name = "aging_drift";
  aging.parts = {{{Sensor::accel_x}, {{"per_s", 1e-9, "m/s2/s"}, {"reference_utc_s", 1.7e9, "s"}}, {}}};
  const std::vector<ModelTerm> terms = {aging};
  const Mechanisms second(terms, campaign.runs[1], 1);
  const Segment& segment = campaign.runs[1].run.segments.front();
  EXPECT_NEAR(second.contribution(Sensor::accel_x, {&segment, 500.0, 0.0, 20.0}), 1e-9 * (100000.0 + 500.0), 1e-15);
}

}  // namespace
}  // namespace soak::calib::forward
