// SPDX-License-Identifier: Apache-2.0
// Effects hidden in designed campaigns: magnitudes, truth, determinism.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/hash.h"
#include "hal/sim/effects/catalogue.h"
#include "tests/long_tests.h"
#include "tests/sim/design_support.h"

namespace soak::hal::sim {
namespace {

using nlohmann::json;
using test::designed_files;
using test::hidden;
using test::Table;
using test::table_of;

const std::map<std::string, double> kBlockSigma = {{"gyro_x", 0.004},  {"gyro_y", 0.004},  {"gyro_z", 0.004},
                                                   {"accel_x", 0.002}, {"accel_y", 0.002}, {"accel_z", 0.002}};
const std::vector<std::string> kNames = {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"};

/// Removes from `values` what each column can explain by itself, over and over: the projection that the columns span
/// together is the limit (backfitting). Independent of any orthogonal basis.
void backfit(std::vector<double>& values, const std::vector<std::vector<double>>& columns) {
  for (int round = 0; round < 400; ++round) {
    for (const std::vector<double>& column : columns) {
      double dot = 0.0;
      double square = 0.0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        dot += column[i] * values[i];
        square += column[i] * column[i];
      }
      for (std::size_t i = 0; i < values.size(); ++i) values[i] -= dot / square * column[i];
    }
  }
}

/// Indicator columns of what the blocks have in common, times `factor`.
void add_indicators(const std::vector<std::string>& keys, const std::vector<double>& factor,
                    std::vector<std::vector<double>>& columns) {
  for (const std::string& key : std::set<std::string>(keys.begin(), keys.end())) {
    std::vector<double> column;
    for (std::size_t i = 0; i < keys.size(); ++i) column.push_back(keys[i] == key ? factor[i] : 0.0);
    columns.push_back(column);
  }
}

/// RMS of what a refitted base leaves of the contributions that the truth lists, over the block's repeatability.
double magnitude_from_truth(const json& truth) {
  const std::vector<std::string> way = {"a", "b", "c", "d", "e", "f", "g", "f", "e", "d", "c", "b", "a"};
  const json& blocks = truth["blocks"];
  std::vector<std::string> plateaus;
  std::vector<std::string> runs;
  std::array<std::vector<double>, 3> up;
  const std::vector<double> ones(blocks.size(), 1.0);
  for (const json& block : blocks) {
    runs.push_back(block[0]);
    plateaus.push_back(way.at(block[1].get<std::size_t>()));
    const std::string position = block[2];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      up[axis].push_back(position[1] != "XYZ"[axis] ? 0.0 : position[0] == '+' ? 1.0 : -1.0);
    }
  }
  const json& effect = truth["units"][0]["effects"][0];
  double sum = 0.0;
  for (const auto& [name, size] : effect["sensors"].items()) {
    const auto index = static_cast<std::size_t>(std::find(kNames.begin(), kNames.end(), name) - kNames.begin());
    std::vector<double> values;
    for (const json& row : effect["contributions"]) values.push_back(row[index].get<double>() / kBlockSigma.at(name));
    std::vector<std::vector<double>> columns;
    add_indicators(plateaus, ones, columns);
    add_indicators(runs, ones, columns);
    if (index >= 3) {
      add_indicators(plateaus, up[index - 3], columns);
      columns.push_back(up[(index - 2) % 3]);
      columns.push_back(up[(index - 1) % 3]);
    }
    backfit(values, columns);
    sum += std::pow(test::rms_of(values), 2.0);
  }
  return std::sqrt(sum / static_cast<double>(effect["sensors"].size()));
}

TEST(HiddenCampaign, ScalesEveryEffectOfBlocksToItsMagnitude) {
  SOAK_LONG_TEST();
  for (const CatalogueEntry& entry : catalogue()) {
    if (entry.measure != Measure::blocks) continue;
    SCOPED_TRACE(std::string(entry.name));
    const auto files = designed_files("[design]\nkind = \"three\"\ncontributions = true\n" +
                                      hidden(std::string(entry.name), "magnitude = 0.6", 7));
    ASSERT_EQ(files.outcome.exit_status, 0) << files.outcome.errors;
    EXPECT_NEAR(files.truth["units"][0]["effects"][0]["magnitude"].get<double>(), 0.6, 0.001);
    EXPECT_NEAR(magnitude_from_truth(files.truth), 0.6, 0.003);
  }
}

TEST(HiddenCampaign, PutsIntoTheRecordingWhatTheTruthSays) {
  for (const std::string name : {"thermal_hysteresis", "sensor_lag", "scale_nonlinearity", "reposition_creep"}) {
    SCOPED_TRACE(name);
    const std::string design = "[design]\nkind = \"one\"\ncontributions = true\n";
    const auto with =
        designed_files(design + hidden(name, name == "sensor_lag" ? "amplitude = 300" : "amplitude = 0.1"));
    const Table plain = table_of(designed_files(design).csv);
    const Table changed = table_of(with.csv);
    const json& contributions = with.truth["units"][0]["effects"][0]["contributions"];
    ASSERT_EQ(plain.rows.size(), changed.rows.size());
    std::array<double, 6> sum{};
    std::size_t rows = 0;
    for (std::size_t i = 0; i < plain.rows.size(); ++i) {
      if (plain.rows[i].at("position").empty()) continue;
      const std::array<std::string, 6> columns = {"gx_dps", "gy_dps", "gz_dps", "ax_mps2", "ay_mps2", "az_mps2"};
      for (std::size_t s = 0; s < 6; ++s) sum[s] += (changed.number(i, columns[s]) - plain.number(i, columns[s])) / 6.0;
      if (++rows % 6 != 0) continue;
      for (std::size_t s = 0; s < 6; ++s) {
        ASSERT_NEAR(sum[s], contributions[rows / 6 - 1][s].get<double>(), 1.1e-5);  // rows are rounded to 1e-5
      }
      sum = {};
    }
    EXPECT_EQ(rows / 6, contributions.size());
  }
}

TEST(HiddenCampaign, CountsAgeingAgainstTheRunOffsets) {
  const auto files = designed_files("[design]\ncontributions = true\n" + hidden("aging_drift", "magnitude = 1.2"));
  const json& effect = files.truth["units"][0]["effects"][0];
  double pooled = 0.0;
  for (const auto& [name, size] : effect["sensors"].items()) {
    const auto index = static_cast<std::size_t>(std::find(kNames.begin(), kNames.end(), name) - kNames.begin());
    std::map<std::string, std::vector<double>> by_run;
    for (std::size_t i = 0; i < files.truth["blocks"].size(); ++i) {
      by_run[files.truth["blocks"][i][0]].push_back(effect["contributions"][i][index]);
    }
    std::vector<double> means;
    for (const auto& [run, values] : by_run) means.push_back(test::mean_of(values));
    const double mean = test::mean_of(means);
    for (double& value : means) value -= mean;
    pooled += std::pow(test::rms_of(means) / (index < 3 ? 0.02 : 0.01), 2.0);
  }
  EXPECT_NEAR(std::sqrt(pooled / static_cast<double>(effect["sensors"].size())), 1.2, 0.003);
}

TEST(HiddenCampaign, ClipsTheShareOfRowsThatTheMagnitudeAsksFor) {
  const auto files = designed_files("[design]\n" + hidden("saturation", "magnitude = 0.6\nsensors = [\"accel_y\"]"));
  const double rail = files.truth["units"][0]["effects"][0]["size"]["value"];
  const Table table = table_of(files.csv);
  double rows = 0.0;
  double clipped = 0.0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].at("position").empty()) continue;
    rows += 1.0;
    const double reading = std::abs(table.number(i, "ay_mps2"));
    EXPECT_LE(reading, rail + 1e-5);
    clipped += reading > rail - 1e-5 ? 1.0 : 0.0;
  }
  EXPECT_NEAR(clipped / rows, 0.06, 0.015) << "noise and run offsets move readings over the rail and back";
}

TEST(HiddenCampaign, QuantizesToTheStepOfTheTruth) {
  const auto files = designed_files("[design]\n" + hidden("quantization", "magnitude = 1.2\nsensors = [\"gyro_z\"]"));
  const json& size = files.truth["units"][0]["effects"][0]["size"];
  EXPECT_EQ(size["unit"], "deg/s");
  const double step = size["value"];
  EXPECT_NEAR(step, 1.2 * 0.004 * std::sqrt(6.0), 1e-6);  // the truth is rounded
  const Table table = table_of(files.csv);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].at("position").empty()) continue;
    const double steps = table.number(i, "gz_dps") / step;
    ASSERT_NEAR(steps, std::round(steps), 1e-3);
  }
}

TEST(HiddenCampaign, MakesNoiseGrowWithTemperature) {
  const auto files =
      designed_files("[design]\n" + hidden("noise_vs_temperature", "amplitude = 0.01\nsensors = [\"gyro_y\"]"));
  const Table table = table_of(files.csv);
  std::map<std::string, std::vector<double>> differences;  // of neighbouring rows: free of all that is slow
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    if (row.at("position").empty() || row.at("position") != table.rows[i - 1].at("position")) continue;
    differences[row.at("plateau_c")].push_back(table.number(i, "gy_dps") - table.number(i - 1, "gy_dps"));
  }
  // 600 differences in -20 and 70 °C: 4 standard errors of the ratio, with neighbours correlated by 1/2, are 20 %.
  EXPECT_NEAR(test::rms_of(differences["70"]) / test::rms_of(differences["-20"]), std::exp(0.9), 0.2 * std::exp(0.9));
}

TEST(HiddenCampaign, StatesTheLargestHalfGapOfAHysteresis) {
  const auto files = designed_files(
      "[design]\n" + hidden("thermal_hysteresis", "amplitude = 0.1\nsensors = [\"gyro_x\", \"accel_z\"]"));
  const json& sensors = files.truth["units"][0]["effects"][0]["sensors"];
  // Between turning points 90 °C apart every play is used up: the gap is the amplitude, and at most 27 % more at 70 °C.
  EXPECT_GT(sensors["gyro_x"]["size"].get<double>(), 0.09);
  EXPECT_LT(sensors["gyro_x"]["size"].get<double>(), 0.13);
  EXPECT_NEAR(sensors["accel_z"]["size"].get<double>() / sensors["gyro_x"]["size"].get<double>(), 0.5, 1e-6);
}

TEST(HiddenCampaign, VariesTheStrengthBetweenRunsWhereAsked) {
  const auto files =
      designed_files("[design]\namplitude_spread = 0.3\n" + hidden("warmup_transient", "magnitude = 1.2"));
  const auto strengths = files.truth["units"][0]["effects"][0]["strength_of_pass"].get<std::vector<double>>();
  ASSERT_EQ(strengths.size(), 6U);
  EXPECT_EQ(std::set<double>(strengths.begin(), strengths.end()).size(), 6U);
  for (const double strength : strengths) EXPECT_NEAR(strength, 1.0, 0.9);
}

TEST(HiddenCampaign, SaysWhichMagnitudesAreOutOfReach) {
  for (const auto& [effect, design] :
       std::map<std::string, std::string>{{"fixture_tilt", "one"}, {"aging_drift", "one"}}) {
    const auto files = designed_files(hidden(effect, "magnitude = 0.6"), {"--design", design});
    EXPECT_EQ(files.outcome.exit_status, 2);
    EXPECT_NE(files.outcome.errors.find(effect), std::string::npos) << files.outcome.errors;
  }
}

TEST(HiddenCampaign, IsAFunctionOfItsSeeds) {
  const std::string design = "[design]\nkind = \"mixed\"\n";
  const auto first = designed_files(design + hidden("telegraph_noise", "magnitude = 0.6", 3));
  const auto same = designed_files(design + hidden("telegraph_noise", "magnitude = 0.6", 3));
  const auto other = designed_files(design + hidden("telegraph_noise", "magnitude = 0.6", 4));
  EXPECT_EQ(first.csv, same.csv);
  EXPECT_EQ(first.truth, same.truth);
  EXPECT_NE(first.csv, other.csv);
  EXPECT_NE(first.csv, designed_files(design + hidden("telegraph_noise", "magnitude = 0.6", 3), {"--seed", "2"}).csv);
}

TEST(HiddenCampaign, HidesAPairAsTheSumOfBoth) {
  const std::string design = "[design]\nkind = \"one\"\n";
  const std::string rate = hidden("temperature_rate", "amplitude = 0.2");
  const std::string supply = hidden("supply_sensitivity", "amplitude = 0.5\nsensors = [\"gyro_x\"]");
  const Table plain = table_of(designed_files(design).csv);
  const Table first = table_of(designed_files(design + rate).csv);
  const Table second = table_of(designed_files(design + supply).csv);
  const Table both = table_of(designed_files(design + rate + supply).csv);
  for (std::size_t i = 0; i < plain.rows.size(); ++i) {
    const double sum = first.number(i, "gx_dps") + second.number(i, "gx_dps") - plain.number(i, "gx_dps");
    ASSERT_NEAR(both.number(i, "gx_dps"), sum, 2.1e-5);
  }
}

// The bytes before there were hidden effects. Decimals are fixed, far above the rounding of different libraries.
TEST(HiddenCampaign, SaysWhatCandidatesWouldDoAndLeavesTheRecordingAlone) {
  const std::string design = "[design]\nkind = \"three\"\ncontributions = true\n";
  const std::string size = "magnitude = 0.3";
  const std::string table = hidden("warmup_transient", size, 5);
  const auto with = designed_files(design + table);
  const auto without = designed_files(design);
  std::string candidates = "[[candidate]]" + table.substr(table.find('\n'));
  candidates += "[[candidate]]\neffect = \"sensor_lag\"\n" + size + "\nseed = 5\n";
  const auto both = designed_files(design + table + candidates);
  const auto only_candidates = designed_files(design + candidates);
  ASSERT_EQ(both.outcome.exit_status, 0) << both.outcome.errors;
  EXPECT_EQ(both.csv, with.csv);
  EXPECT_EQ(only_candidates.csv, without.csv);
  EXPECT_TRUE(only_candidates.truth["units"][0]["effects"].empty());
  const json& listed = only_candidates.truth["units"][0]["candidates"];
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0], with.truth["units"][0]["effects"][0]);
  EXPECT_EQ(listed[1]["name"], "sensor_lag");
  EXPECT_EQ(listed, both.truth["units"][0]["candidates"]);
}

TEST(HiddenCampaign, StatesTheNoiseWithItsDriftFactor) {
  const json noise = designed_files("[design]\nkind = \"one\"\ndrift_factor = 3\n").truth["noise"];
  EXPECT_EQ(noise["gyro"], json::parse(R"({"unit": "deg/s", "block_sigma": 0.004, "placement_sigma": 0.006,
                                           "visit_sigma": 0.006, "run_sigma": 0.02})"));
  EXPECT_EQ(noise["accel"], json::parse(R"({"unit": "m/s2", "block_sigma": 0.002, "placement_sigma": 0.003,
                                            "visit_sigma": 0.003, "run_sigma": 0.01})"));
}

TEST(HiddenCampaign, LeavesOrdinaryCampaignsAsTheyWere) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_campaign_program({"--out", folder.path().string(), "--units", "2", "--runs", "2", "--rows-per-position",
                                  "3", "--config", test::kShippedConfig})
                .exit_status,
            0);
  std::string all;
  for (const std::string name : {"campaign/SIM-0001.csv", "campaign/SIM-0002.csv", "verification/SIM-0001.csv",
                                 "verification/SIM-0002.csv", "truth.json"}) {
    all += test::content_of(folder.path() / name);
  }
  base::Sha256 hash;
  hash.update(all);
  EXPECT_EQ(base::to_hex(hash.finish()), "0744ac955f6ea43bb8023ac956902472f960ffda4b57c198942d7a9d31515fec");
}

}  // namespace
}  // namespace soak::hal::sim
