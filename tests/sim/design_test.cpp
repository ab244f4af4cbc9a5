// SPDX-License-Identifier: Apache-2.0
// Designed campaigns, as their files show them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "tests/sim/design_support.h"

#include "tests/long_tests.h"

namespace soak::hal::sim {
namespace {

using test::designed_files;
using test::Table;
using test::table_of;

/// Rows in position of one visit, by run and by the order of visits in it.
struct VisitRows {
  std::string run;
  std::string plateau_c;
  std::string sweep;
  std::vector<std::size_t> rows;
};

std::vector<VisitRows> visits_of(const Table& table) {
  std::vector<VisitRows> visits;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    if (row.at("position").empty()) continue;
    if (visits.empty() || visits.back().run != row.at("run") || visits.back().plateau_c != row.at("plateau_c")) {
      visits.push_back({row.at("run"), row.at("plateau_c"), row.at("sweep"), {}});
    }
    visits.back().rows.push_back(i);
  }
  return visits;
}

std::map<std::string, std::vector<std::string>> plateaus_by_run(const Table& table) {
  std::map<std::string, std::vector<std::string>> plateaus;
  for (const VisitRows& visit : visits_of(table)) plateaus[visit.run].push_back(visit.plateau_c);
  return plateaus;
}

TEST(Design, IsByDefaultSixEqualRunsOfThirteenVisitsWithSixPositionsAndThreeBlocks) {
  const auto files = designed_files("", {"--design", "identical"});
  ASSERT_EQ(files.outcome.exit_status, 0) << files.outcome.errors;
  EXPECT_LT(files.csv.size(), 1'500'000U);
  const Table table = table_of(files.csv);
  const std::vector<VisitRows> visits = visits_of(table);
  ASSERT_EQ(visits.size(), 6U * 13U);
  const std::vector<std::string> way = {"-20", "-5", "10", "25", "40", "55", "70", "55", "40", "25", "10", "-5", "-20"};
  for (const auto& [run, plateaus] : plateaus_by_run(table)) EXPECT_EQ(plateaus, way) << run;
  const std::vector<std::string> order = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
  for (const VisitRows& visit : visits) {
    ASSERT_EQ(visit.rows.size(), 6U * 18U);
    for (std::size_t i = 0; i < visit.rows.size(); ++i) {
      EXPECT_EQ(table.rows[visit.rows[i]].at("position"), order[i / 18]);
      if (i % 18 == 0) continue;
      EXPECT_NEAR(table.number(visit.rows[i], "t_s") - table.number(visit.rows[i - 1], "t_s"), 10.0, 1e-6);
    }
  }
}

TEST(Design, LogsRampsAndSurroundingsThroughout) {
  const Table table = table_of(designed_files("", {"--design", "identical"}).csv);
  std::set<std::string> compressor;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    compressor.insert(row.at("compressor"));
    EXPECT_NEAR(table.number(i, "supply_v"), 5.0, 0.3);
    EXPECT_EQ(row.at("t_s"), row.at("t_since_power_s"));
    EXPECT_TRUE(row.at("phase") == "soak" || row.at("position").empty());
    if (i == 0 || row.at("run") != table.rows[i - 1].at("run")) continue;
    const double step_s = table.number(i, "t_s") - table.number(i - 1, "t_s");
    EXPECT_GT(step_s, 0.0);
    EXPECT_LE(step_s, 60.0) << "no gap in " << row.at("t_s");
    EXPECT_NEAR(table.number(i, "utc_s") - table.number(i - 1, "utc_s"), step_s, 1.0);
  }
  EXPECT_EQ(compressor, (std::set<std::string>{"0", "1"}));
}

TEST(Design, TogglesTheCompressorInsidePlateausAndSettlesTheTemperature) {
  const Table table = table_of(designed_files("", {"--design", "identical"}).csv);
  int toggling = 0;
  const std::vector<VisitRows> visits = visits_of(table);
  for (const VisitRows& visit : visits) {
    std::set<std::string> states;
    for (const std::size_t row : visit.rows) states.insert(table.rows[row].at("compressor"));
    toggling += states.size() == 2 ? 1 : 0;
    EXPECT_NEAR(table.number(visit.rows.front(), "temp_c"), std::stod(visit.plateau_c), 2.0);
    EXPECT_NEAR(table.number(visit.rows.back(), "temp_c"), std::stod(visit.plateau_c), 1.2);
  }
  EXPECT_GT(toggling, 60);
}

TEST(Design, MixesProfilesAndCyclesThePowerOnce) {
  const auto files = designed_files("", {"--design", "mixed"});
  EXPECT_LT(files.csv.size(), 1'500'000U);
  const Table table = table_of(files.csv);
  const auto plateaus = plateaus_by_run(table);
  ASSERT_EQ(plateaus.size(), 7U) << "six passes, one of them in two runs";
  std::set<std::string> starts;
  std::set<std::vector<std::string>> ways;
  std::size_t visits = 0;
  for (const auto& [run, way] : plateaus) {
    starts.insert(way.front());
    ways.insert(way);
    visits += way.size();
  }
  EXPECT_EQ(visits, 6U * 13U);
  EXPECT_GE(starts.size(), 3U);
  EXPECT_GE(ways.size(), 4U);
  std::map<double, int> passes;
  for (const auto& run : files.truth["runs"]) passes[run["pass"].get<double>()]++;
  EXPECT_EQ(passes.size(), 6U);
  // Ramps: time from the first row of a ramp to the first row in position, per run.
  std::set<long> durations_s;
  for (std::size_t i = 1, start = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].at("phase") == "ramp" && table.rows[i - 1].at("phase") != "ramp") start = i;
    if (table.rows[i].at("phase") != "ramp" && table.rows[i - 1].at("phase") == "ramp" &&
        table.rows[i].at("run") == table.rows[start].at("run")) {
      durations_s.insert(std::lround(table.number(i, "t_s") - table.number(start, "t_s")));
    }
  }
  EXPECT_GE(durations_s.size(), 6U);
}

TEST(Design, HasThreeRunsOrOneWhereThatIsAskedFor) {
  EXPECT_EQ(plateaus_by_run(table_of(designed_files("", {"--design", "three"}).csv)).size(), 3U);
  EXPECT_EQ(plateaus_by_run(table_of(designed_files("[design]\nkind = \"one\"\n").csv)).size(), 1U);
  EXPECT_EQ(plateaus_by_run(table_of(designed_files("[design]\nkind = \"three\"\nruns = 4\n").csv)).size(), 4U);
}

TEST(Design, LeavesLogsOutAndNothingElse) {
  const Table bare = table_of(designed_files("", {"--design", "missing_logs"}).csv);
  const Table full = table_of(designed_files("", {"--design", "identical"}).csv);
  const std::vector<std::string> names = {"t_s",      "run",     "phase",   "sweep",           "plateau_c",
                                          "position", "temp_c",  "gx_dps",  "gy_dps",          "gz_dps",
                                          "ax_mps2",  "ay_mps2", "az_mps2", "t_since_power_s", "utc_s"};
  EXPECT_EQ(bare.names, names);
  std::size_t i = 0;
  for (const auto& row : full.rows) {
    if (row.at("phase") == "ramp") continue;
    for (const std::string& name : names) ASSERT_EQ(bare.rows[i].at(name), row.at(name));
    ++i;
  }
  EXPECT_EQ(i, bare.rows.size());
}

TEST(Design, DropsAVisitAndMislabelsAPositionAndSaysWhereInTheTruth) {
  const auto files = designed_files("[design]\ndropped_visit = true\nwrong_position = true\n");
  const Table table = table_of(files.csv);
  const std::vector<VisitRows> visits = visits_of(table);
  EXPECT_EQ(visits.size(), 6U * 13U - 1U);
  EXPECT_EQ(
      plateaus_by_run(table).at("R0" + std::to_string(files.truth["dropped_visit"]["pass"].get<int>() + 1)).size(),
      12U);
  int wrong = 0;
  for (const VisitRows& visit : visits) {
    for (const std::size_t row : visit.rows) {
      const std::string position = table.rows[row].at("position");
      const double force = table.number(row, std::string("a") + static_cast<char>(position[1] + 32) + "_mps2");
      wrong += (position[0] == '+' ? force : -force) < 0.0 ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 18);
  EXPECT_FALSE(files.truth["wrong_position"]["true_position"].get<std::string>().empty());
}

TEST(Design, RoundsTheThermometerToWholeDegrees) {
  const Table table = table_of(designed_files("[design]\nthermometer_step_c = 1.0\n").csv);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    ASSERT_EQ(table.number(i, "temp_c"), std::round(table.number(i, "temp_c")));
  }
}

/// Standard deviations of block means about their placement, of placements about their visit, and of run means, for
/// a gyro that nothing is hidden in; deg/s.
struct Scatter {
  double block = 0.0;
  double placement = 0.0;
  double run = 0.0;
};

Scatter scatter_of(const Table& table, const std::string& column) {
  std::map<std::string, std::vector<double>> placement_means;  // by run and visit
  std::map<std::string, std::vector<double>> run_means;
  double within = 0.0;
  double within_count = 0.0;
  for (const VisitRows& visit : visits_of(table)) {
    for (std::size_t first = 0; first + 18 <= visit.rows.size(); first += 18) {
      std::vector<double> blocks;
      for (std::size_t block = 0; block < 3; ++block) {
        double sum = 0.0;
        for (std::size_t i = 0; i < 6; ++i) sum += table.number(visit.rows[first + 6 * block + i], column) / 6.0;
        blocks.push_back(sum);
      }
      const double mean = test::mean_of(blocks);
      for (const double value : blocks) within += (value - mean) * (value - mean);
      within_count += 2.0;
      placement_means[visit.run + visit.plateau_c + visit.sweep].push_back(mean);
      run_means[visit.run].push_back(mean);
    }
  }
  double between = 0.0;
  double between_count = 0.0;
  for (const auto& [key, means] : placement_means) {
    for (const double value : means) between += std::pow(value - test::mean_of(means), 2.0);
    between_count += static_cast<double>(means.size()) - 1.0;
  }
  std::vector<double> runs;
  for (const auto& [run, means] : run_means) runs.push_back(test::mean_of(means));
  const double run_mean = test::mean_of(runs);
  for (double& value : runs) value -= run_mean;
  const double block = std::sqrt(within / within_count);
  return {block, std::sqrt(std::max(between / between_count - block * block / 3.0, 0.0)), test::rms_of(runs)};
}

// 936 degrees of freedom for blocks (4 standard errors: 9 %), 390 for placements, of which noise of the blocks is 1.3
// times as much again. Where the curve is steep the temperature's settling within a visit adds to both.
TEST(Design, HasTheNoiseThatItStates) {
  SOAK_LONG_TEST();
  const std::string flat =
      "[design]\nknown_effects = false\nsoak_s = 3600.0\n";  // settled: the curve has no slope to show
  const Table plain = table_of(designed_files(flat).csv);
  const Scatter scatter = scatter_of(plain, "gx_dps");
  EXPECT_NEAR(scatter.block, 0.004, 0.0005);
  EXPECT_NEAR(scatter.placement, 0.002, 0.0008);
  EXPECT_GT(scatter.run, 0.005);  // six offsets of 0.02
  EXPECT_LT(scatter.run, 0.04);
  const Scatter drifting = scatter_of(table_of(designed_files(flat + "drift_factor = 3.0\n").csv), "gx_dps");
  EXPECT_NEAR(drifting.block, 0.004, 0.0005);
  EXPECT_NEAR(drifting.placement, 0.006, 0.001);
}

TEST(Design, KeepsWhatIsKnownOnlyWhereItIsAskedTo) {
  SOAK_LONG_TEST();
  const auto difference = [](const Table& table) {
    std::map<std::string, std::vector<double>> by_position;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (!table.rows[i].at("position").empty())
        by_position[table.rows[i].at("position")].push_back(table.number(i, "gz_dps"));
    }
    return std::abs(test::mean_of(by_position["+Z"]) - test::mean_of(by_position["-Z"]));
  };
  // 78 placements of 0.002 each and 234 blocks of 0.004 in either mean: a difference of 0.0005 is one standard
  // deviation.
  EXPECT_LT(difference(table_of(designed_files("[design]\n").csv)), 0.002);
  EXPECT_GT(difference(table_of(designed_files("[design]\nknown_effects = true\n").csv)), 0.015);
}

TEST(Design, RefusesWhatDoesNotGoTogether) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--design", "seven"}, "'seven'"},
      {{"--design", "one", "--rows-per-position", "5"}, "--rows-per-position"},
      {{}, "--truth"},
  };
  for (const auto& [arguments, named] : cases) {
    const auto files = designed_files("", arguments);
    EXPECT_EQ(files.outcome.exit_status, 2);
    EXPECT_NE(files.outcome.errors.find(named), std::string::npos) << files.outcome.errors;
  }
}

}  // namespace
}  // namespace soak::hal::sim
