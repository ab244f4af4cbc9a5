// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/temperature_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calib/gap/campaign/campaign.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

/// A campaign of one run that follows `temp_c` for `seconds`, with an observation each minute.
struct LoggedHistory {
  LoggedCampaign campaign;
  Observations observations;

  LoggedHistory(double seconds, const std::function<double(double)>& temp_c) {
    LoggedRun run;
    for (double t_s = 0.0; t_s <= seconds; t_s += 10.0) {
      run.log.t_s.push_back(t_s);
      run.log.temp_c.push_back(temp_c(t_s));
      run.log.t_since_power_s.push_back(t_s);
    }
    campaign.runs.push_back(run);
    observations.runs = {"R1"};
    observations.logged = {0};
    for (double t_s = 60.0; t_s < seconds; t_s += 60.0) {
      Observation row;
      row.t_s = t_s;
      row.temp_c = temp_c(t_s);
      observations.rows.push_back(row);
    }
  }
};

// A first-order lag behind the ramp a·t is late by a τ (1 − e^(−t/τ)).
TEST(TemperatureHistory, LagBehindARampIsTheAnalyticOne) {
  const LoggedHistory logged(7200.0, [](double t_s) { return 0.02 * t_s - 20.0; });
  const TemperatureHistory history(logged.campaign, logged.observations);
  for (const double tau_s : {60.0, 300.0, 1500.0}) {
    const auto lag = history.lag(tau_s);
    for (std::size_t i = 0; i < lag.size(); ++i) {
      const double t_s = logged.observations.rows[i].t_s;
      EXPECT_NEAR(lag[i], -0.02 * tau_s * (1.0 - std::exp(-t_s / tau_s)), 1e-9);
    }
  }
}

TEST(TemperatureHistory, RateIsTheSlopeOfTheThermometer) {
  const LoggedHistory logged(3600.0, [](double t_s) { return 25.0 + 10.0 * std::sin(t_s / 900.0); });
  const TemperatureHistory history(logged.campaign, logged.observations);
  for (std::size_t i = 3; i + 3 < history.rate().size(); ++i) {
    const double t_s = logged.observations.rows[i].t_s;
    EXPECT_NEAR(history.rate()[i], 10.0 / 900.0 * std::cos(t_s / 900.0), 1e-4);
  }
}

TEST(TemperatureHistory, MemoryOfTheBranchStaysWhileTheTemperatureStands) {
  // Heats from −20 °C, stands, turns.
  const auto temp_c = [](double t_s) {
    if (t_s < 3000.0) return -20.0 + 0.02 * t_s;
    if (t_s < 6000.0) return 40.0 + 0.02 * std::sin(t_s);
    return 40.0 - 0.02 * (t_s - 6000.0);
  };
  const LoggedHistory logged(9000.0, temp_c);
  const TemperatureHistory history(logged.campaign, logged.observations);
  const auto memory = history.branch_memory(10.0);
  const auto at = [&](double t_s) { return memory[static_cast<std::size_t>(t_s / 60.0) - 1]; };
  EXPECT_NEAR(at(60.0), -1.0 + 2.0 * (1.0 - std::exp(-(1.2 - 0.25) / 10.0)), 0.01);
  EXPECT_NEAR(at(2940.0), 1.0, 0.01);
  EXPECT_NEAR(at(5940.0), at(3060.0), 1e-6);
  EXPECT_NEAR(at(8940.0), -1.0, 0.02);
}

// A ramp that has gone on for long: a τ behind from the first row. A memory that has come the same way is full.
TEST(TemperatureHistory, CanBeUnderWayAtTheStart) {
  const LoggedHistory logged(3600.0, [](double t_s) { return 70.0 - 0.02 * t_s; });
  const TemperatureHistory history(logged.campaign, logged.observations);
  for (const double behind : history.lag(300.0, true)) EXPECT_NEAR(behind, 0.02 * 300.0, 1e-9);
  for (const double h : history.branch_memory(10.0, 1.0)) EXPECT_NEAR(h, -1.0, 1e-9);
  const auto against = history.branch_memory(10.0, -1.0);
  const auto between = history.branch_memory(10.0, 0.0);
  for (std::size_t i = 0; i < against.size(); ++i) {
    const double faded = std::exp(-(0.02 * logged.observations.rows[i].t_s - 0.25) / 10.0);
    EXPECT_NEAR(against[i], -1.0 + 2.0 * faded, 1e-6);
    EXPECT_NEAR(between[i], -1.0 + faded, 1e-6);
  }
}

TEST(TemperatureHistory, AHoleInTheLogIsTold) {
  LoggedHistory logged(7200.0, [](double) { return 25.0; });
  EXPECT_TRUE(TemperatureHistory(logged.campaign, logged.observations).continuous());
  auto& log = logged.campaign.runs[0].log;
  log.t_s.erase(log.t_s.begin() + 100, log.t_s.begin() + 140);
  log.temp_c.erase(log.temp_c.begin() + 100, log.temp_c.begin() + 140);
  log.t_since_power_s.erase(log.t_since_power_s.begin() + 100, log.t_since_power_s.begin() + 140);
  EXPECT_FALSE(TemperatureHistory(logged.campaign, logged.observations).continuous());
}

TEST(RunLog, HoldsMeansOfTenSeconds) {
  Recording recording;
  for (int i = 0; i < 1000; ++i) {
    recording.t_s.push_back(0.1 * i);
    recording.temp_c.push_back(i < 500 ? 20.0 : 30.0);
  }
  recording.auxiliary.push_back({"supply_v", std::vector<double>(1000, 5.0)});
  const RunLog log = make_run_log(recording);
  ASSERT_EQ(log.t_s.size(), 10U);
  EXPECT_NEAR(log.t_s[3], 34.95, 1e-9);
  EXPECT_EQ(log.temp_c[4], 20.0);
  EXPECT_EQ(log.temp_c[5], 30.0);
  EXPECT_EQ(log.supply_v[9], 5.0);
  EXPECT_TRUE(log.chamber_c.empty());
  EXPECT_NEAR(log.t_since_power_s[0], 4.95, 1e-9);
}

}  // namespace
}  // namespace soak::calib::gap
