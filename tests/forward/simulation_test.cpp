// SPDX-License-Identifier: Apache-2.0
#include "calib/forward/simulation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "calib/forward/thermal_history.h"
#include "calib/gap/report/gap_report.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::forward {
namespace {

namespace made_up = gap::made_up;

/// The truth of made_up::campaign() as a model: tables of its bias curves, scale error 1000 ppm.
SimulatedModel truth() {
  SimulatedModel model;
  for (const Sensor sensor : kSensors) {
    SensorCalibration calibration;
    calibration.sensor = sensor;
    TableCurve table{-30.0, 0.1, {}, {}};
    for (int k = 0; k <= 1100; ++k) table.values.push_back(made_up::bias(sensor, -30.0 + 0.1 * k));
    calibration.bias = table;
    if (!is_gyro(sensor)) calibration.scale_ppm = TableCurve{-30.0, 110.0, {1000.0, 1000.0}, {}};
    model.calibration.sensors.push_back(calibration);
  }
  return model;
}

/// A hysteresis play on three sensors, by a rule of its own: half a millirad per second at the upper branch.
made_up::Hidden hysteresis() {
  return [state = 0.0, last_c = 0.0, run = -1](Sensor sensor, const made_up::Moment& m) mutable {
    if (m.run != run) {
      run = m.run;
      last_c = m.temp_c;
      state = -1.0;
    }
    const double way = m.temp_c - last_c;
    state += (std::copysign(1.0, way) - state) * (1.0 - std::exp(-std::abs(way) / 8.0));
    last_c = m.temp_c;
    return is_gyro(sensor) ? 5e-4 * state : 0.0;
  };
}

TEST(Simulation, WithTheTruthOnlyScatterIsLeft) {
  const made_up::Plan plan;
  const auto campaign = made_up::campaign(plan, made_up::nothing());
  const auto left = compare(simulate(truth(), campaign));
  // Blocks scatter by one unit, placements and visits by half of one each.
  const double units = std::sqrt(1.0 + 0.25 + 0.25);
  for (const Sensor sensor : kSensors) {
    const auto& sensor_left = left[index_of(sensor)];
    ASSERT_TRUE(sensor_left);
    const double unit = is_gyro(sensor) ? plan.gyro_block : plan.accel_block;
    EXPECT_NEAR(sensor_left->rms, units * unit, 0.1 * unit) << name_of(sensor);
    EXPECT_NEAR(sensor_left->noise_rms, unit, 1e-9);
    EXPECT_EQ(sensor_left->runs.size(), 6U);
  }
}

/// The truth, its gyro curves moved at each plateau to where the campaign's readings are: what a thermal fit would do.
SimulatedModel refitted(const gap::LoggedCampaign& campaign) {
  SimulatedModel model = truth();
  const SimulatedCampaign simulated = simulate(model, campaign);
  for (std::size_t s = 0; s < 3; ++s) {
    std::map<double, std::array<double, 3>> plateaus;  // set point: readings, their sum, sum of temperatures
    for (const SimulatedBlock& block : simulated.blocks) {
      const auto set_c = campaign.runs[static_cast<std::size_t>(block.run)].run.segments[block.segment].plateau_c;
      auto& [count, off, temp_c] = plateaus[*set_c];
      count += 1.0;
      off += *block.measured[s] - *block.simulated[s];
      temp_c += block.temp_c;
    }
    Series moved;  // over temperature
    for (const auto& [set_c, sums] : plateaus) {
      moved.t_s.push_back(sums[2] / sums[0]);
      moved.values.push_back(sums[1] / sums[0]);
    }
    auto& table = std::get<TableCurve>(model.calibration.sensors[s].bias);
    for (std::size_t k = 0; k < table.values.size(); ++k) {
      table.values[k] += moved.at(table.first_c + table.step_c * static_cast<double>(k));
    }
  }
  return model;
}

TEST(Simulation, AnAcceptedTermClosesTheGapThatTheReportSaysItCloses) {
  const auto campaign = made_up::campaign({}, hysteresis());
  const gap::GapReport report = gap::find_gap(campaign, 1);
  ASSERT_EQ(report.conclusion, gap::Conclusion::named) << report.reason;
  ASSERT_EQ(report.effects.front().effect->name, "thermal_hysteresis");
  const auto accepted = gap::accepted_terms(campaign, report, {});
  ASSERT_TRUE(accepted) << accepted.error().message;
  const std::vector<ModelTerm>& terms = *accepted;
  auto freed = campaign;
  ASSERT_TRUE(subtract_terms(terms, freed).empty());
  SimulatedModel with = refitted(freed);
  with.terms = terms;
  const auto before = compare(simulate(refitted(campaign), campaign));
  const auto after = compare(simulate(with, campaign));
  for (std::size_t s = 0; s < 3; ++s) {
    ASSERT_TRUE(report.gap[s] && report.gap[s]->closed_fraction);
    const double floor = report.gap[s]->floor_rms;
    const double closed = (before[s]->rms - after[s]->rms) / (before[s]->rms - floor);
    EXPECT_NEAR(closed, *report.gap[s]->closed_fraction, 0.1) << s;
    EXPECT_GT(closed, 0.85);
  }
}

TEST(Simulation, WhatIsTakenOffIsWhatSimulationAdds) {
  const auto recorded = made_up::campaign({.runs = 2}, hysteresis());
  ModelTerm term;
  term.name = "thermal_hysteresis";
  term.parts = {{{Sensor::gyro_x}, {{"amplitude", 5e-4, "rad/s"}, {"width_c", 8.0, "K"}}, {1e-12}}};
  SimulatedModel with = truth();
  with.terms = {term};
  auto freed = recorded;
  EXPECT_TRUE(subtract_terms({term}, freed).empty());
  const auto simulated = compare(simulate(with, recorded));
  const auto taken = compare(simulate(truth(), freed));
  EXPECT_NEAR(simulated[0]->rms, taken[0]->rms, 1e-12);
  EXPECT_LT(simulated[0]->rms, 0.5 * compare(simulate(truth(), recorded))[0]->rms);
  // Segments lose what their blocks lose, in the mean.
  const Segment& before = recorded.runs[1].run.segments[20];
  const Segment& after = freed.runs[1].run.segments[20];
  double blocks = 0.0;
  for (std::size_t b = 0; b < 3; ++b)
    blocks += (before.blocks[b].sensor[0].mean - after.blocks[b].sensor[0].mean) / 3.0;
  EXPECT_NEAR(before.sensor[0].mean - after.sensor[0].mean, blocks, 1e-15);
}

TEST(Simulation, KnowsTheRotationOfTheEarth) {
  auto campaign = made_up::campaign({.runs = 1}, made_up::nothing());
  campaign.runs.front().run.site.latitude_deg = 90.0;
  campaign.runs.front().run.site.gravity_mps2 = 9.81;
  const auto at_the_pole = simulate(truth(), campaign);
  campaign.runs.front().run.site.latitude_deg.reset();
  const auto nowhere = simulate(truth(), campaign);
  constexpr double kEarth_rps = 7.292115e-5;
  for (std::size_t i = 0; i < nowhere.blocks.size(); ++i) {
    const Segment& segment = campaign.runs.front().run.segments[nowhere.blocks[i].segment];
    EXPECT_NEAR(*at_the_pole.blocks[i].simulated[2] - *nowhere.blocks[i].simulated[2],
                kEarth_rps * segment.position->up[2], 1e-12);
  }
}

}  // namespace
}  // namespace soak::calib::forward
