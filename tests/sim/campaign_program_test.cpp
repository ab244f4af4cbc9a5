// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/programs/programs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/sim/support.h"

namespace soak::hal::sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

ProgramOutcome run_into(const fs::path& folder, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"--out", folder.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_campaign_program(arguments);
}

/// Content of all files below a folder, by relative path.
std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = test::content_of(entry.path());
  }
  return files;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

/// Means over the rows of one segment: temperature, then the six sensors in file units.
struct SegmentMean {
  std::string run;
  std::string position;
  double temp_c = 0.0;
  std::array<double, 6> sensor{};
  int count = 0;
};

/// The segments of a CSV text, in its order: rows in a row with the same run and position that is not empty.
std::vector<SegmentMean> segments_of(const std::string& csv) {
  std::vector<SegmentMean> segments;
  std::istringstream stream(csv);
  std::string line;
  std::getline(stream, line);
  bool fresh = true;
  while (std::getline(stream, line)) {
    const std::vector<std::string> fields = split(line);
    if (fields[5].empty()) {
      fresh = true;
      continue;
    }
    if (fresh || segments.back().position != fields[5] || segments.back().run != fields[1]) {
      segments.push_back({fields[1], fields[5]});
    }
    fresh = false;
    SegmentMean& segment = segments.back();
    segment.temp_c += std::stod(fields[7]);
    for (std::size_t i = 0; i < 6; ++i) segment.sensor[i] += std::stod(fields[8 + i]);
    ++segment.count;
  }
  for (SegmentMean& segment : segments) {
    segment.temp_c /= segment.count;
    for (double& value : segment.sensor) value /= segment.count;
  }
  return segments;
}

/// Linear interpolation in a list on the truth's grid, −30 ... 70 °C each 0.25 °C, held at the ends.
double on_grid(const json& values, double temp_c) {
  const double place = std::clamp((temp_c + 30.0) / 0.25, 0.0, 400.0);
  const auto i = std::min(static_cast<std::size_t>(place), std::size_t{399});
  const double fraction = place - static_cast<double>(i);
  return (1 - fraction) * values[i].get<double>() + fraction * values[i + 1].get<double>();
}

TEST(CampaignProgram, WritesOneFilePerUnitAndTheTruth) {
  const test::TemporaryFolder folder;
  const ProgramOutcome outcome = run_into(folder.path() / "new", {"--units", "2", "--runs", "1"});
  EXPECT_EQ(outcome.exit_status, 0) << outcome.errors;
  std::set<std::string> names;
  for (const auto& [name, content] : files_in(folder.path() / "new")) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"campaign/SIM-0001.csv", "campaign/SIM-0002.csv", "truth.json",
                                          "verification/SIM-0001.csv", "verification/SIM-0002.csv"}));
}

TEST(CampaignProgram, WritesTheSameBytesForTheSameSeedAndOthersForAnother) {
  const test::TemporaryFolder folder;
  const std::vector<std::string> size = {"--units", "2", "--runs", "2", "--rows-per-position", "3", "--seed"};
  for (const auto& [name, seed] : std::map<std::string, std::string>{{"a", "7"}, {"b", "7"}, {"c", "8"}}) {
    std::vector<std::string> arguments = size;
    arguments.push_back(seed);
    ASSERT_EQ(run_into(folder.path() / name, arguments).exit_status, 0);
  }
  const auto first = files_in(folder.path() / "a");
  const auto other = files_in(folder.path() / "c");
  EXPECT_EQ(first, files_in(folder.path() / "b"));
  for (const auto& [name, content] : first) EXPECT_NE(content, other.at(name)) << name;
}

TEST(CampaignProgram, WritesTheColumnsOfTheImportFormat) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_into(folder.path(), {"--units", "1", "--runs", "2"}).exit_status, 0);
  const std::string header =
      "t_s,run,phase,sweep,plateau_c,position,chamber_c,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2";
  for (const std::string name : {"campaign", "verification"}) {
    std::istringstream csv(test::content_of(folder.path() / name / "SIM-0001.csv"));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, header);
    std::string run;
    double t_s = -1.0;
    while (std::getline(csv, line)) {
      const auto fields = split(line);
      ASSERT_EQ(fields.size(), 14U) << line;
      const double now_s = std::stod(fields[0]);
      EXPECT_TRUE(fields[1] == run ? now_s > t_s : now_s == 0.0) << line;
      EXPECT_TRUE(fields[2] == "soak" || fields[5].empty()) << line;
      run = fields[1];
      t_s = now_s;
    }
  }
}

/// RMS of `errors` whose standard deviation is `sigma`, within four standard errors (a fifth wider, since slow noise
/// makes neighbours alike), and none beyond five.
void expect_scatter(const std::vector<double>& errors, double sigma) {
  const double tolerance = 4 * 1.2 / std::sqrt(2.0 * static_cast<double>(errors.size()));
  EXPECT_NEAR(test::rms_of(errors), sigma, tolerance * sigma);
  for (const double error : errors) EXPECT_LT(std::abs(error), 5 * sigma);
}

// The mean of one axis pointing up and down is bias plus power-on offset; half their difference is input times scale
// for an accelerometer and g-sensitivity for a gyro. White noise is 0.7 of the variance of a segment mean; the slow
// rest has a correlation of 0.785 between segments that start 35 s apart. So a mean scatters by sqrt(0.35 + 0.15
// · 1.785) = 0.79 of one segment, half a difference by sqrt(0.35 + 0.15 · 0.215) = 0.62.
void expect_pairs_reveal(const json& sensor, std::size_t index, const std::vector<SegmentMean>& segments,
                         const std::map<std::string, double>& offsets) {
  const bool gyro = index < 3;
  const double sigma = gyro ? 0.005 : 0.003;
  std::vector<double> bias_errors;
  std::vector<double> difference_errors;
  for (std::size_t i = 0; i + 1 < segments.size(); ++i) {
    const SegmentMean& first = segments[i];
    const SegmentMean& second = segments[i + 1];
    if (first.position[1] != "XYZ"[index % 3] || second.position[1] != first.position[1]) continue;
    const double temp_c = (first.temp_c + second.temp_c) / 2;
    const double sign = first.position[0] == '+' ? 1.0 : -1.0;
    const double offset = offsets.at(first.run);
    const double half_difference = sign * (first.sensor[index] - second.sensor[index]) / 2;
    const double expected = gyro ? sensor["g_sensitivity_dps_per_g"][index].get<double>()
                                 : 9.80665 * (1 + 1e-6 * on_grid(sensor["scale_ppm"], temp_c));
    bias_errors.push_back((first.sensor[index] + second.sensor[index]) / 2 - offset - on_grid(sensor["bias"], temp_c));
    difference_errors.push_back(half_difference - expected);
  }
  ASSERT_EQ(bias_errors.size(), offsets.size() * (offsets.size() == 1 ? 39U : 41U));
  expect_scatter(bias_errors, 0.79 * sigma);
  expect_scatter(difference_errors, 0.62 * sigma);
}

TEST(CampaignProgram, WritesReadingsWhoseUpAndDownPairsRevealTheTruth) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_into(folder.path(), {"--units", "2", "--runs", "3"}).exit_status, 0);
  const json truth = json::parse(test::content_of(folder.path() / "truth.json"));
  ASSERT_EQ(truth["units"].size(), 2U);
  ASSERT_EQ(truth["temp_c"].size(), 401U);
  const std::array<std::string, 6> names = {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"};
  for (const json& unit : truth["units"]) {
    const std::string file = unit["unit"].get<std::string>() + ".csv";
    const auto campaign = segments_of(test::content_of(folder.path() / "campaign" / file));
    const auto verification = segments_of(test::content_of(folder.path() / "verification" / file));
    for (std::size_t index = 0; index < names.size(); ++index) {
      SCOPED_TRACE(file + " " + names[index]);
      const json& sensor = unit["sensors"][names[index]];
      std::map<std::string, double> offsets;
      for (std::size_t run = 0; run < 3; ++run) offsets[truth["runs"][run]] = sensor["power_on_offset"][run];
      expect_pairs_reveal(sensor, index, campaign, offsets);
      expect_pairs_reveal(sensor, index, verification,
                          {{truth["verification_run"], sensor["verification_power_on_offset"]}});
    }
  }
}

TEST(CampaignProgram, StatesTheSpanOfTheCurveThatItLists) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run_into(folder.path(), {"--units", "3", "--runs", "1", "--rows-per-position", "1"}).exit_status, 0);
  const json truth = json::parse(test::content_of(folder.path() / "truth.json"));
  for (const json& unit : truth["units"]) {
    for (const json& sensor : unit["sensors"]) {
      const auto bias = sensor["bias"].get<std::vector<double>>();
      ASSERT_EQ(bias.size(), truth["temp_c"].size());
      const auto [least, greatest] = std::minmax_element(bias.begin(), bias.end());
      EXPECT_NEAR(sensor["uncompensated_span"].get<double>(), *greatest - *least, 2e-7);
      EXPECT_EQ(sensor["scale_ppm"].is_null(), sensor["unit"] == "deg/s");
    }
  }
}

TEST(CampaignProgram, RefusesWrongUsageWithStatusTwoAndSaysWhatIsWrong) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{}, "--out"},
      {{"--out"}, "--out"},
      {{"--out", ""}, "--out"},
      {{"--out", "x", "--frobnicate", "1"}, "'--frobnicate'"},
      {{"--out", "x", "--out", "y"}, "--out"},
      {{"--out", "x", "--seed", "-1"}, "--seed"},
      {{"--out", "x", "--seed", "many"}, "'many'"},
      {{"--out", "x", "--units", "0"}, "9999"},
      {{"--out", "x", "--runs", "2.5"}, "--runs"},
      {{"--out", "x", "--rows-per-position", "0"}, "--rows-per-position"},
      {{"--out", "x", "--config", "/nonexistent/lab.toml"}, "/nonexistent/lab.toml"},
      {{"--out", "/dev/null/x"}, "/dev/null/x"},
  };
  for (const auto& [arguments, named] : cases) {
    const ProgramOutcome outcome = run_campaign_program(arguments);
    EXPECT_EQ(outcome.exit_status, 2) << named;
    EXPECT_NE(outcome.errors.find(named), std::string::npos) << outcome.errors;
    EXPECT_TRUE(outcome.output.empty());
  }
}

TEST(CampaignProgram, PrintsItsUsageWhenAsked) {
  const ProgramOutcome outcome = run_campaign_program({"--help"});
  EXPECT_EQ(outcome.exit_status, 0);
  EXPECT_NE(outcome.output.find("--rows-per-position"), std::string::npos);
}

}  // namespace
}  // namespace soak::hal::sim
