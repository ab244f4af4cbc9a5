// SPDX-License-Identifier: Apache-2.0
// Files of format versions 1.0 to 1.8 kept in tests/data/golden: every later version must read them, to the same
// values.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;
using nlohmann::json;

struct Golden {
  const char* name;
  Calibration calibration;
};

std::vector<Golden> goldens() {
  return {{"fis", golden_fis()},
          {"mixed", golden_mixed()},
          {"whole", golden_whole()},
          {"table", golden_table()},
          {"referenced", golden_referenced()},
          {"couplings", golden_couplings()},
          {"thermometers", golden_thermometers()},
          {"gyros", golden_gyros()},
          {"one_way", golden_one_way()},
          {"history", golden_history()},
          {"unreleased", golden_unreleased()}};
}

base::Bytes blob_of(const Golden& golden) { return read_file(data_file(std::string(golden.name) + ".soakcal")); }

/// What make_values.py computed by the formulas of docs/blob-format.md, without any code of this project.
json values_of(const Golden& golden) {
  std::ifstream in(data_file(std::string(golden.name) + ".values.json"));
  return json::parse(in);
}

double span_of(const json& points, const char* key) {
  double least = points[0][key].get<double>();
  double largest = least;
  for (const json& point : points) {
    least = std::min(least, point[key].get<double>());
    largest = std::max(largest, point[key].get<double>());
  }
  return largest - least;
}

TEST(GoldenFiles, AreWhatTheEncoderWritesByteForByte) {
  for (const Golden& golden : goldens()) {
    const auto bytes = encode(golden.calibration);
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(*bytes, blob_of(golden)) << golden.name;
  }
}

TEST(GoldenFiles, RuntimeGivesTheValuesComputedElsewhere) {
  for (const Golden& golden : goldens()) {
    const base::Bytes bytes = blob_of(golden);
    soak_cal cal;
    ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    const json values = values_of(golden);
    for (const auto& [name, points] : values["sensors"].items()) {
      const int sensor = static_cast<int>(index_of(*sensor_named(name)));
      const bool has_scale = !points[0]["scale_ppm"].is_null();
      for (const json& point : points) {
        const auto temp_c = point["temp_c"].get<float>();
        const soak_status expected_status = point["in_range"].get<bool>() ? SOAK_OK : SOAK_CLAMPED;
        float value = NAN;
        EXPECT_EQ(soak_bias(&cal, sensor, temp_c, &value), expected_status);
        EXPECT_NEAR(static_cast<double>(value), point["bias"].get<double>(), 1e-6 * span_of(points, "bias"));
        ASSERT_EQ(soak_scale_ppm(&cal, sensor, temp_c, &value), has_scale ? expected_status : SOAK_ABSENT);
        if (!has_scale) continue;
        EXPECT_NEAR(static_cast<double>(value), point["scale_ppm"].get<double>(), 1e-6 * span_of(points, "scale_ppm"));
      }
    }
  }
}

TEST(GoldenFiles, DecodedCurvesGiveTheValuesComputedElsewhere) {
  for (const Golden& golden : goldens()) {
    const auto calibration = decode(blob_of(golden));
    ASSERT_TRUE(calibration) << calibration.error().message;
    const json values = values_of(golden);
    EXPECT_EQ(calibration->sensors.size(), values["sensors"].size());
    for (const SensorCalibration& sensor : calibration->sensors) {
      const json& points = values["sensors"][std::string(name_of(sensor.sensor))];
      for (const json& point : points) {
        const double temp_c = std::clamp(point["temp_c"].get<double>(), sensor.temp_min_c, sensor.temp_max_c);
        EXPECT_NEAR(evaluate(sensor.bias, temp_c), point["bias"].get<double>(), 5e-7 * span_of(points, "bias"));
      }
    }
  }
}

TEST(GoldenFiles, CorrectedSamplesAreThoseComputedElsewhere) {
  for (const Golden& golden : goldens()) {
    const base::Bytes bytes = blob_of(golden);
    soak_cal cal;
    ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    const json values = values_of(golden);
    for (const json& sample : values["corrected"]) {
      const auto raw = sample["raw"].get<std::vector<float>>();
      const auto expected = sample["out"].get<std::vector<double>>();
      float out[6];
      std::uint32_t flags = 0;
      EXPECT_GE(soak_apply(&cal, sample["temp_c"].get<float>(), raw.data(), out, &flags), SOAK_OK);
      // float32 steps near 10 m/s² and 1 rad/s are 1e-6 and 1e-7; a dozen operations
      for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(static_cast<double>(out[i]), expected[i], i < 3 ? 5e-7 : 5e-6);
    }
  }
}

TEST(GoldenFiles, SamplesWithATemperatureOfEachSensorAreCorrectedAsComputedElsewhere) {
  const base::Bytes bytes = read_file(data_file("thermometers.soakcal"));
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  std::ifstream in(data_file("thermometers.values.json"));
  const json samples = json::parse(in)["corrected_temps"];
  ASSERT_GT(samples.size(), 10U);
  for (const json& sample : samples) {
    const auto temps_c = sample["temps_c"].get<std::vector<float>>();
    const auto raw = sample["raw"].get<std::vector<float>>();
    const auto expected = sample["out"].get<std::vector<double>>();
    float out[6];
    std::uint32_t flags = 0;
    EXPECT_EQ(soak_apply_temps(&cal, temps_c.data(), raw.data(), out, &flags), SOAK_OK);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(static_cast<double>(out[i]), expected[i], i < 3 ? 5e-7 : 5e-6);
  }
}

/// The bytes in the ```hex block of the format's page.
base::Bytes worked_example() {
  std::ifstream page(std::string(SOAK_TEST_FOLDER) + "/../docs/blob-format.md");
  std::string line;
  bool inside = false;
  base::Bytes bytes;
  while (std::getline(page, line)) {
    if (line.starts_with("```")) inside = line == "```hex";
    if (!inside || line.starts_with("```")) continue;
    std::istringstream fields(line.substr(0, line.find(';')));
    std::string field;
    fields >> field;  // offset
    while (fields >> field) bytes.push_back(static_cast<std::uint8_t>(std::stoi(field, nullptr, 16)));
  }
  return bytes;
}

TEST(FormatPage, WorkedExampleIsAFileOfTheFormat) {
  const base::Bytes bytes = worked_example();
  const auto calibration = decode(bytes);
  ASSERT_TRUE(calibration) << calibration.error().message;
  EXPECT_EQ(calibration->unit, "SN1");
  ASSERT_EQ(calibration->sensors.size(), 1U);
  EXPECT_NEAR(evaluate(calibration->sensors[0].bias, 10.0), 0.015, 1e-9);  // as the page says
}

// Run with --gtest_also_run_disabled_tests --gtest_filter='*WriteThemAnew': see tests/data/golden/README.md.
TEST(GoldenFiles, DISABLED_WriteThemAnew) {
  for (const Golden& golden : goldens()) {
    const base::Bytes bytes = *encode(golden.calibration);
    std::ofstream out(data_file(std::string(golden.name) + ".soakcal"), std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    ASSERT_TRUE(out.flush());
  }
}

}  // namespace
}  // namespace soak::calib
