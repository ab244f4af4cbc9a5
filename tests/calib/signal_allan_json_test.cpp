// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "base/random.h"
#include "calib/signal/documents/detail/record.h"
#include "calib/signal/documents/signal_json.h"
#include "calib/signal/noise/noise.h"
#include "tests/calib/schema_check.h"
#include "tests/errors.h"
#include "tests/long_tests.h"
#include "tests/signal/filtered_noise.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using signal::NoiseSource;
using Samples = std::vector<double>;

Samples operator+(Samples a, const Samples& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

Samples white(std::size_t count, std::uint64_t seed) {
  return signal::white_noise(count, 1.0, {.rate_hz = 1.0, .seed = seed});
}

SignalRecord record_of(Samples values) {
  SignalRecord record{.column = "gx_dps", .unit = "deg/s", .rate_hz = 1.0};
  for (std::size_t i = 0; i < values.size(); ++i) record.t_s.push_back(static_cast<double>(i));
  record.values = std::move(values);
  return record;
}

/// The document, checked against its schema.
json document_of(const Samples& values, const AllanRequest& request = {}) {
  const auto document = allan_json(record_of(values), request);
  EXPECT_TRUE(document) << document.error().message;
  if (!document) return {};
  std::ifstream file(std::filesystem::path(SOAK_TEST_FOLDER) / ".." / "docs" / "schema" / "signal-allan.schema.json");
  EXPECT_EQ(tests::SchemaCheck(json::parse(file)).mistake(json::parse(document->dump())), "");
  return *document;
}

/// Text of the warning with this code; empty: there is none.
std::string warning(const json& document, const std::string& code) {
  for (const json& warning : document["warnings"]) {
    if (warning["code"] == code) return warning["text"];
  }
  return {};
}

bool holds(const json& coefficient, double truth) {
  return coefficient["ci95"][0].get<double>() <= truth && truth <= coefficient["ci95"][1].get<double>();
}

TEST(AllanJson, AStepIsNamedWithItsTimeAndHeight) {
  Samples values = white(20000, 31);
  for (std::size_t i = 12345; i < values.size(); ++i) values[i] += 5.0;
  const auto found = signal_json::step(values);
  ASSERT_TRUE(found);
  const double time = static_cast<double>(found->at);
  const double height = found->height;
  EXPECT_TRUE(base::mentions(warning(document_of(values), "step"),
                             {fmt::format("{:.3g} deg/s", height), fmt::format("{:g} s", time)}));
  // Means of at most 20000/16 samples, a boundary at most an eighth of that away: an eighth of the height may be lost.
  EXPECT_NEAR(time, 12345.0, 160.0);
  EXPECT_NEAR(height, 5.0, 0.8);
}

TEST(AllanJson, AStepThatPassesForARandomWalkIsFound) {
  // Without the step no such record has K; with it K is found, with a narrow interval and without a misfit.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Samples values = white(20000, 3200 + seed);
    for (std::size_t i = 9000; i < values.size(); ++i) values[i] += 1.0;
    EXPECT_NE(warning(document_of(values), "step"), "") << seed;
  }
}

TEST(AllanJson, OutliersAreCountedAndTheFirstIsNamed) {
  for (const double height : {50.0, -200.0}) {
    Samples values = white(20000, 33);
    values[7000] += height;
    EXPECT_EQ(signal_json::outliers(values).at, (std::vector<std::size_t>{7000}));
    EXPECT_TRUE(base::mentions(warning(document_of(values), "outliers"), {"1 ", "7000 s"}));
    EXPECT_EQ(warning(document_of(values), "step"), "") << "an outlier is no step";
    values[15000] -= height;
    values[0] += height;
    EXPECT_EQ(signal_json::outliers(values).at, (std::vector<std::size_t>{0, 7000, 15000}));
    EXPECT_TRUE(base::mentions(warning(document_of(values), "outliers"), {"3 ", " 0 s"}));
  }
}

TEST(AllanJson, StepsAndOutliersOfPhaseAreThoseOfItsRate) {
  Samples values = white(20000, 34);
  for (std::size_t i = 12345; i < values.size(); ++i) values[i] += 5.0;
  values[500] += 100.0;
  Samples phase = {0.0};
  for (const double value : values) phase.push_back(phase.back() + value);
  const json document = document_of(phase, {.phase = true});
  EXPECT_NE(warning(document, "step"), "");
  EXPECT_TRUE(base::mentions(warning(document, "outliers"), {" 500 s"}));
}

TEST(AllanJson, NoiseWithoutStepsAndOutliersRaisesNoAlarm) {
  using namespace signal_json;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const NoiseSource source{.rate_hz = 1.0, .seed = 35000 + seed};
    const std::size_t n = 1000 * (1 + seed % 8);
    Samples coarse = signal::white_noise(n, 1.0, source);
    for (double& value : coarse) value = 3.0 * std::round(value / 3.0);
    for (const Samples& values : {signal::white_noise(n, 1.0, source), signal::flicker_noise(n, 1.0, source),
                                  signal::random_walk(n, 1.0, source),
                                  signal::white_noise(n, 1.0, source) + signal::flicker_noise(n, 0.3, source) +
                                      signal::random_walk(n, 0.02, source),
                                  coarse, signal::white_noise(n, 1.0, source) + signal::rate_ramp(n, 0.01, 1.0)}) {
      EXPECT_TRUE(outliers(values).at.empty()) << seed;
      EXPECT_FALSE(step(values)) << seed;
    }
  }
}

TEST(AllanJson, CoefficientsHoldTheTruthWhereSingleRowsAreLost) {
  SOAK_LONG_TEST();
  constexpr double kFlicker = 0.1;
  constexpr int kRecords = 50;
  // Bias instability is the least of the curve, at its end here: sqrt(N^2/tau + 0.664^2 B^2)/0.664.
  const double least = std::sqrt(kFlicker * kFlicker + 1.0 / 3333.0 / 0.441);
  for (const double lost : {0.002, 0.01, 0.05, 0.2}) {
    int n = 0;
    int b = 0;
    for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
      Samples values =
          white(10000, 36000 + seed) + signal::flicker_noise(10000, kFlicker, {.rate_hz = 1.0, .seed = 36000 + seed});
      base::Random random(36000 + seed, 1);
      for (double& value : values) {
        if (random.uniform() < lost) value = std::numeric_limits<double>::quiet_NaN();
      }
      const auto document = allan_json(record_of(values), {});
      ASSERT_TRUE(document);
      ASSERT_FALSE((*document)["coefficients"].empty());
      n += holds((*document)["coefficients"]["angle_random_walk"], 1.0);
      b += holds((*document)["coefficients"]["bias_instability"], least);
    }
    // 95 % - 3 % as everywhere, and three times its scatter, sqrt(0.92 0.08/50) = 3.8 %, less.
    EXPECT_GE(n, 40) << lost << ", N";
    EXPECT_GE(b, 40) << lost << ", B";
    std::printf("%g %% lost: N %d, B %d of %d\n", 100.0 * lost, n, b, kRecords);
  }
}

TEST(AllanJson, BridgedSamplesAreToldAndTheirAveragingTimesLeftOut) {
  Samples values = white(20000, 37);
  for (std::size_t i = 10; i < values.size(); i += 20) values[i] = std::numeric_limits<double>::quiet_NaN();
  const json document = document_of(values);
  EXPECT_TRUE(base::mentions(warning(document, "bridged"), {"5 %"}));
  EXPECT_TRUE(document["ci95"][0][0].is_null());
  EXPECT_TRUE(document["fitted"][0].is_null());
  EXPECT_FALSE(document["ci95"].back()[0].is_null());
  EXPECT_EQ(document["ci95"].size(), document["tau_s"].size());
  // sqrt(1 + 1.5 * 5 %): each lost row is carried by two neighbours of weight 1.5.
  EXPECT_TRUE(base::mentions(warning(document, "bridged"), {"3.7 %"}));
}

TEST(AllanJson, AFewBridgedSamplesChangeNothing) {
  Samples values = white(20000, 38);
  for (const std::size_t i : {100U, 5000U, 12000U}) values[i] = std::numeric_limits<double>::quiet_NaN();
  const json document = document_of(values);
  EXPECT_EQ(warning(document, "bridged"), "");
  EXPECT_FALSE(document["ci95"][0][0].is_null());
}

TEST(AllanJson, ARecordOfWhichAThirdIsBridgedIsNotFitted) {
  Samples values = white(3000, 39);
  for (std::size_t i = 1; i < values.size(); i += 3) values[i] = std::numeric_limits<double>::quiet_NaN();
  const json document = document_of(values);
  EXPECT_TRUE(base::mentions(warning(document, "no_fit"), {"33 %"}));
  EXPECT_TRUE(document["coefficients"].empty());
}

TEST(AllanJson, WhereNothingIsFittedTheListsAreAsLongAsTheTimesAndNull) {
  const json document = document_of({1.0, 2.0, 1.5, 2.5, 1.0});
  ASSERT_NE(warning(document, "no_fit"), "");
  const std::size_t shown = document["tau_s"].size();
  for (const char* key : {"ci95", "fitted", "degrees_of_freedom"}) {
    ASSERT_EQ(document[key].size(), shown) << key;
  }
  EXPECT_EQ(document["ci95"][0], json::array({nullptr, nullptr}));
  EXPECT_TRUE(document["fitted"][0].is_null());
}

TEST(AllanJson, TheTimeOfAnAbsentMarkovTermHasNoUpperLimit) {
  const json coefficients = document_of(white(4000, 40))["coefficients"];
  ASSERT_FALSE(coefficients["markov_time"]["found"].get<bool>());
  EXPECT_TRUE(coefficients["markov_time"]["ci95"][1].is_null());
  EXPECT_GT(coefficients["markov_sigma"]["ci95"][1].get<double>(), 0.0);
}

TEST(AllanJson, AProbabilityTooSmallForANumberIsSaidToBeBelowIt) {
  Samples values = white(40000, 41);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += 10.0 * std::sin(0.543 * static_cast<double>(i));
  const json document = document_of(values);
  ASSERT_EQ(document["p_value"].get<double>(), 0.0);
  EXPECT_NE(warning(document, "poor_fit").find("p below 1e-300"), std::string::npos) << warning(document, "poor_fit");
}

TEST(AllanJson, TheLowPassOfTheUnitIsNamedAndTheDensityIsThatBelowIt) {
  const filtered_noise::Unit unit{
      .filter = "butter2", .corner_hz = 42.0, .rate_hz = 500.0, .length_s = 600.0, .white = 0.01};
  const filtered_noise::Record made = filtered_noise::make_record(unit, 19);
  SignalRecord record = record_of(made.rate);
  record.rate_hz = unit.rate_hz;
  const auto document = allan_json(record, {});
  ASSERT_TRUE(document);
  const json& filter = (*document)["low_pass"];
  EXPECT_TRUE(filter["found"].get<bool>());
  EXPECT_NEAR(filter["corner_hz"].get<double>(), 42.0, 4.2);
  EXPECT_GT(filter["fitted_from_s"].get<double>(), 1.0 / 42.0);
  EXPECT_TRUE((*document)["coefficients"]["angle_random_walk"]["found"].get<bool>());
  EXPECT_TRUE(holds((*document)["coefficients"]["angle_random_walk"], made.density));
  EXPECT_FALSE((*document)["coefficients"]["bias_instability"]["found"].get<bool>());
  for (std::size_t i = 0; i < (*document)["tau_s"].size(); ++i) {
    EXPECT_FALSE((*document)["ci95"][i][0].is_null());
    EXPECT_FALSE((*document)["fitted"][i].is_null());
  }
  // The same of its integral.
  record.values = {0.0};
  for (const double rate : made.rate) record.values.push_back(record.values.back() + rate / unit.rate_hz);
  record.t_s.push_back(static_cast<double>(record.t_s.size()));
  record.unit = "deg";
  const auto of_phase = allan_json(record, {.phase = true});
  ASSERT_TRUE(of_phase);
  EXPECT_NEAR((*of_phase)["low_pass"]["corner_hz"].get<double>(), filter["corner_hz"].get<double>(), 1e-6);
  EXPECT_FALSE(document_of(white(4000, 42))["low_pass"]["found"].get<bool>());
}

TEST(AllanJson, AStuckSensorIsRefused) {
  Samples stuck(1000, 0.25);
  stuck[500] = std::numeric_limits<double>::quiet_NaN();
  const auto allan = allan_json(record_of(stuck), {});
  ASSERT_FALSE(allan);
  EXPECT_EQ(allan.error().kind, base::ErrorKind::bad_input);
  EXPECT_FALSE(allan_json(record_of(stuck), {.phase = true}));
  const auto psd = psd_json(record_of(stuck), {});
  ASSERT_FALSE(psd);
  EXPECT_EQ(psd.error().kind, base::ErrorKind::bad_input);
  // Stuck in one position after the other.
  for (std::size_t i = 500; i < 520; ++i) stuck[i] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 520; i < 1000; ++i) stuck[i] = 0.75;
  EXPECT_FALSE(allan_json(record_of(stuck), {}));
}

}  // namespace
}  // namespace soak::calib
