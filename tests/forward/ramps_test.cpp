// SPDX-License-Identifier: Apache-2.0
// Terms that the branches of a recording without plateaus gave: what they mean, and that they close the gap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "calib/forward/mechanisms.h"
#include "calib/forward/simulation.h"
#include "calib/gap/ramps/detail/branch_search.h"
#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_ramps.h"

namespace soak::calib::forward {
namespace {

using gap::Candidate;
using gap::LoggedCampaign;
using gap::made_up::Ramp;
using gap::made_up::RampPlan;
using gap::made_up::ramps;

gap::made_up::RampEffect no_effect() {
  return [](const Ramp& ramp, Sensor) { return std::vector<double>(ramp.t_s.size(), 0.0); };
}

/// A rod with play of 5 K to either side, pushed by the temperature.
gap::made_up::RampEffect rod(double size) {
  return [=](const Ramp& ramp, Sensor) {
    std::vector<double> result;
    double rod_c = ramp.temp_c.front();
    for (const double c : ramp.temp_c) {
      rod_c = std::clamp(rod_c, c - 5.0, c + 5.0);
      result.push_back(size * (c - rod_c) / 5.0);
    }
    return result;
  };
}

/// A candidate with parameters 1, 2... as `gap accept` would keep it.
ModelTerm term_of(const gap::ramps::RampEffect& effect, const Candidate& candidate) {
  const gap::Meaning meaning = effect.shown.meaning(candidate, Sensor::gyro_x);
  ModelTerm term;
  term.name = effect.effect->name;
  term.parts = {{{Sensor::gyro_x}, meaning.given, {}, {}}};
  for (std::size_t i = 0; i < meaning.estimated.size(); ++i) {
    const double parameter = 1.0 + static_cast<double>(i);
    term.parts[0].parameters.push_back(
        {meaning.estimated[i].name, parameter * meaning.estimated[i].per_parameter, meaning.estimated[i].unit});
  }
  return term;
}

/// Largest difference between mechanism and regressor over the blocks, each about its mean, over the largest value.
double disagreement(const LoggedCampaign& campaign, const Candidate& candidate, const ModelTerm& term) {
  const std::vector<ModelTerm> terms = {term};
  const Mechanisms mechanisms(terms, campaign.runs.front(), 1);
  EXPECT_TRUE(mechanisms.not_evaluated().empty());
  const Segment& segment = campaign.runs.front().run.segments.front();
  const Eigen::MatrixXd& columns = candidate.columns[index_of(Sensor::gyro_x)];
  const Eigen::Index count = columns.cols();
  Eigen::VectorXd expected = columns * Eigen::VectorXd::LinSpaced(count, 1.0, static_cast<double>(count));
  Eigen::VectorXd said(expected.size());
  EXPECT_EQ(static_cast<std::size_t>(said.size()), segment.blocks.size());
  for (Eigen::Index i = 0; i < said.size(); ++i) {
    const Block& block = segment.blocks[static_cast<std::size_t>(i)];
    const Moment moment{&segment, block.t_s, 0.5 * block.duration_s, block.temp_c};
    said(i) = candidate.shifts ? mechanisms.element_temp_c(Sensor::gyro_x, moment) - block.temp_c
                               : mechanisms.contribution(Sensor::gyro_x, moment);
  }
  expected.array() -= expected.mean();
  said.array() -= said.mean();
  return (said - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

TEST(TermsOfRamps, SayWhatTheRegressorsSaidThatFoundThem) {
  LoggedCampaign campaign = ramps({}, no_effect());
  gap::RunLog& log = campaign.runs.front().log;
  for (const double t_s : log.t_s) {
    log.supply_v.push_back(5.0 + 0.1 * std::sin(t_s / 500.0));
    log.compressor.push_back(0.5 + 0.5 * std::sin(t_s / 300.0));
  }
  const auto recording = gap::ramps::ramp_recording(campaign);
  ASSERT_TRUE(recording);
  const gap::TemperatureHistory history(campaign, recording->observations);
  const std::set<std::string_view> history_effects = {"thermal_hysteresis", "temperature_rate", "sensor_lag"};
  int compared = 0;
  for (const gap::ramps::RampEffect& effect : gap::ramps::effects_on_ramps(*recording, history, false)) {
    if (effect.nuisance) continue;
    for (const Candidate& candidate : effect.candidates()) {
      // Logged channels count by their mean over a block of 30 s here, over a minute there (less at the start).
      const bool of_temperature = history_effects.contains(effect.effect->name);
      EXPECT_LT(disagreement(campaign, candidate, term_of(effect, candidate)), of_temperature ? 2e-2 : 6e-2)
          << effect.effect->name << ' ' << candidate.shape;
      ++compared;
    }
  }
  EXPECT_GT(compared, 60);
}

TEST(TermsOfRamps, AreAcceptedAndLeaveNothingToFind) {
  RampPlan plan;
  plan.branches = 4;
  const LoggedCampaign campaign = ramps(plan, rod(8.0));
  const gap::GapReport report = gap::find_gap(campaign, 1);
  ASSERT_EQ(report.conclusion, gap::Conclusion::named) << report.reason;
  auto terms = gap::accepted_terms(campaign, report, {});
  ASSERT_TRUE(terms) << terms.error().message;
  ASSERT_EQ(terms->size(), 1U);
  const ModelTerm& term = terms->front();
  EXPECT_LT(term.temp_min_c, -10.0);
  EXPECT_GT(term.temp_max_c, 60.0);
  std::size_t sensors = 0;
  for (const TermPart& part : term.parts) {
    EXPECT_FALSE(part.parameters.empty());
    sensors += part.sensors.size();
  }
  std::size_t named = 0;
  for (const gap::NamedEffect& effect : report.effects) named += effect.sensors.size();
  EXPECT_EQ(sensors, named);

  centre(campaign, *terms);
  LoggedCampaign freed = campaign;
  EXPECT_TRUE(subtract_terms(*terms, freed).empty());
  const gap::GapReport after = gap::find_gap(freed, 2);
  EXPECT_EQ(after.conclusion, gap::Conclusion::none) << after.reason;
}

TEST(TermsOfRamps, AreShownInASimulationOfTheRamp) {
  const LoggedCampaign campaign = ramps({}, rod(8.0));
  SimulatedModel model;
  for (const Sensor sensor : kSensors) {
    SensorCalibration calibration;
    calibration.sensor = sensor;
    calibration.bias = TableCurve{-30.0, 120.0, {0.0, 0.0}, {}};
    model.calibration.sensors.push_back(calibration);
  }
  const SimulatedCampaign simulated = simulate(model, campaign);
  EXPECT_EQ(simulated.blocks.size(), campaign.runs.front().run.segments.front().blocks.size());
}

}  // namespace
}  // namespace soak::calib::forward
