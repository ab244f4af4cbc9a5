// SPDX-License-Identifier: Apache-2.0
// What is stated of couplings on its way out of the laboratory: fit, model document, calibration file, runtime.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/model/model_document.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using samples::golden_couplings;
using samples::golden_gyros;
using samples::golden_mixed;
using samples::head_of;

constexpr std::uint16_t kCouplingsSection = 0x0023;

TEST(CouplingsInTheFile, ComeBackAsTheyWereStated) {
  const auto read = decode(*encode(golden_couplings()));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->misalignment_uncertainty, golden_couplings().misalignment_uncertainty);
  EXPECT_EQ(read->g_sensitivity_uncertainty, golden_couplings().g_sensitivity_uncertainty);
  EXPECT_EQ(read->even_order, golden_couplings().even_order);
}

TEST(CouplingsInTheFile, ThatAreNotStatedLeaveTheFileOfAnEarlierVersion) {
  const base::Bytes without = *encode(golden_mixed());
  EXPECT_EQ(samples::get<std::uint16_t>(without, 10), 0) << "minor version";
  EXPECT_EQ(head_of(without, kCouplingsSection), 0U);
  EXPECT_EQ(samples::get<std::uint16_t>(*encode(golden_couplings()), 10), 3);
}

TEST(CouplingsInTheFile, AreReadByTheRuntime) {
  const base::Bytes bytes = *encode(golden_couplings());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  float sigma[9];
  ASSERT_EQ(soak_coupling_sigma(&cal, SOAK_MISALIGNMENT, sigma), SOAK_OK);
  EXPECT_EQ(sigma[0], 0.0F);
  EXPECT_EQ(sigma[3], 0x1.8p-13F);
  ASSERT_EQ(soak_coupling_sigma(&cal, SOAK_G_SENSITIVITY, sigma), SOAK_OK);
  EXPECT_EQ(sigma[8], 0x1p-17F);
  float value = NAN;
  ASSERT_EQ(soak_even_order(&cal, SOAK_ACCEL_X, &value, sigma), SOAK_OK);
  EXPECT_EQ(value, -0x1p-18F);
  EXPECT_EQ(sigma[0], 0x1p-20F);
  EXPECT_EQ(soak_even_order(&cal, SOAK_ACCEL_Y, &value, sigma), SOAK_ABSENT);
  EXPECT_TRUE(std::isnan(value) && std::isnan(sigma[0]));
  ASSERT_EQ(soak_even_order(&cal, SOAK_ACCEL_Z, &value, sigma), SOAK_OK);
  EXPECT_EQ(value, 0x1p-19F);
  EXPECT_EQ(soak_even_order(&cal, SOAK_GYRO_X, &value, sigma), SOAK_E_ARGUMENT);
  EXPECT_EQ(soak_coupling_sigma(&cal, SOAK_GYRO_MISALIGNMENT, sigma), SOAK_ABSENT);
  EXPECT_EQ(soak_coupling_sigma(&cal, 3, sigma), SOAK_E_ARGUMENT);
}

TEST(GyroMisalignmentInTheFile, ComesBackAsItWasStatedAndMakesAFileOfItsVersion) {
  const base::Bytes bytes = *encode(golden_gyros());
  EXPECT_EQ(samples::get<std::uint16_t>(bytes, 10), 5);
  const auto read = decode(bytes);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_TRUE(read->gyro_misalignment);
  EXPECT_NEAR((*read->gyro_misalignment)[1][2], 0.005, 1e-9);
  EXPECT_EQ(read->gyro_misalignment_uncertainty, golden_gyros().gyro_misalignment_uncertainty);
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  float sigma[9];
  ASSERT_EQ(soak_coupling_sigma(&cal, SOAK_GYRO_MISALIGNMENT, sigma), SOAK_OK);
  EXPECT_EQ(sigma[3], 0x1.8p-12F);
}

TEST(GyroMisalignmentInTheFile, IsRefusedWhereTheFormatCannotCarryIt) {
  Calibration calibration = golden_gyros();
  (*calibration.gyro_misalignment)[0][0] = 0.1;
  EXPECT_FALSE(encode(calibration));
  calibration = golden_gyros();
  (*calibration.gyro_misalignment)[0][1] = 0.3;
  EXPECT_FALSE(encode(calibration));
  calibration = golden_gyros();
  calibration.gyro_misalignment_uncertainty->standard[0][1] = -1.0;
  EXPECT_FALSE(encode(calibration));
}

TEST(GyroMisalignmentInTheFile, AGyroThatIsNotFiniteDoesNotSpoilTheOthers) {
  const base::Bytes bytes = *encode(golden_gyros());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  const float raw[6] = {NAN, 0.1F, 0.2F, 0.0F, 0.0F, 9.8F};
  float out[6];
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply(&cal, 20.0F, raw, out, &flags), SOAK_INVALID);
  EXPECT_TRUE((flags & SOAK_FLAG_UNCOUPLED) != 0U && (flags & SOAK_FLAG_INVALID(0)) != 0U);
  EXPECT_TRUE(std::isfinite(out[1]) && std::isfinite(out[2]));
}

TEST(CouplingsInTheFile, ThatTheFileDoesNotStateAreAbsentInTheRuntime) {
  const base::Bytes bytes = *encode(golden_mixed());
  soak_cal cal;
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
  float sigma[9];
  EXPECT_EQ(soak_coupling_sigma(&cal, SOAK_MISALIGNMENT, sigma), SOAK_ABSENT);
  EXPECT_TRUE(std::isnan(sigma[0]) && std::isnan(sigma[8]));
}

TEST(CouplingsInTheFile, AreRefusedWhereTheFormatCannotCarryThem) {
  const std::vector<std::pair<const char*, std::function<void(Calibration&)>>> cases = {
      {"no matrix", [](Calibration& c) { c.accel_misalignment.reset(); }},
      {"no g-sensitivity", [](Calibration& c) { c.g_sensitivity.reset(); }},
      {"negative", [](Calibration& c) { c.misalignment_uncertainty->standard[0][1] = -1e-6; }},
      {"not a number", [](Calibration& c) { c.g_sensitivity_uncertainty->standard[2][2] = NAN; }},
      {"diagonal", [](Calibration& c) { c.misalignment_uncertainty->standard[1][1] = 1e-6; }},
      {"term", [](Calibration& c) { c.even_order[0]->value = INFINITY; }},
      {"its error", [](Calibration& c) { c.even_order[2]->standard_uncertainty = -1.0; }}};
  for (const auto& [name, spoil] : cases) {
    Calibration calibration = golden_couplings();
    spoil(calibration);
    const auto bytes = encode(calibration);
    ASSERT_FALSE(bytes) << name;
    EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input) << name;
  }
}

TEST(CouplingsInTheFile, ThatBreakTheFormatMakeTheFileRefused) {
  const base::Bytes good = *encode(golden_couplings());
  const std::size_t payload = head_of(good, kCouplingsSection) + 8;
  ASSERT_GT(payload, 8U);
  const std::vector<std::pair<const char*, std::function<void(base::Bytes&)>>> cases = {
      {"fewer blocks than numbers", [&](base::Bytes& b) { samples::put(b, payload, 0x07U); }},
      {"more blocks than numbers", [&](base::Bytes& b) { samples::put(b, payload, 0x1FU); }},
      {"a diagonal", [&](base::Bytes& b) { samples::put(b, payload + 4, 1e-6F); }},
      {"a negative sigma", [&](base::Bytes& b) { samples::put(b, payload + 8, -1e-6F); }},
      {"an infinite term", [&](base::Bytes& b) { samples::put(b, payload + 76, INFINITY); }},
      {"a negative sigma of a term", [&](base::Bytes& b) { samples::put(b, payload + 80, -1e-6F); }}};
  for (const auto& [name, spoil] : cases) {
    base::Bytes bytes = good;
    spoil(bytes);
    samples::seal(bytes);
    soak_cal cal;
    EXPECT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_E_FORMAT) << name;
    EXPECT_EQ(cal.error_offset, payload - 8) << name;
  }
}

TEST(CouplingsInTheFile, MustFollowTheirMatrixAndStandOnce) {
  base::Bytes twice = *encode(golden_couplings());
  const std::size_t head = head_of(twice, kCouplingsSection);
  const base::Bytes payload(twice.begin() + static_cast<std::ptrdiff_t>(head) + 8,
                            twice.begin() + static_cast<std::ptrdiff_t>(head) + 8 + 92);
  samples::append_section(twice, kCouplingsSection, 1, false, payload);
  EXPECT_FALSE(decode(twice));
  base::Bytes no_matrix = *encode(samples::golden_fis());
  samples::append_section(no_matrix, kCouplingsSection, 1, false, payload);
  EXPECT_FALSE(decode(no_matrix));
}

/// A model of one accelerometer as a fit gives it.
UnitModel model_with_couplings(std::optional<double> type_b) {
  UnitModel model;
  model.unit = "SN-0008";
  const StatedValue entry{.value = 1e-3, .standard_error = 3e-5, .type_b = type_b, .ci95 = 1e-4};
  model.accel_misalignment.emplace();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) (*model.accel_misalignment)[i][j] = entry;
    }
  }
  model.even_order[2] = StatedValue{.value = 2e-6, .standard_error = 3e-7, .type_b = type_b, .ci95 = 1e-6};
  return model;
}

TEST(CouplingsOfAFit, AreStatedWithBothPartsOfTheirUncertainty) {
  const Calibration calibration = make_calibration(model_with_couplings(4e-5));
  ASSERT_TRUE(calibration.misalignment_uncertainty);
  // 3-4-5
  EXPECT_NEAR(calibration.misalignment_uncertainty->standard[0][2], 5e-5, 1e-19);
  EXPECT_EQ(calibration.misalignment_uncertainty->standard[1][1], 0.0);
  EXPECT_FALSE(calibration.misalignment_uncertainty->readings_only);
  EXPECT_FALSE(calibration.even_order[0]);
  ASSERT_TRUE(calibration.even_order[2]);
  EXPECT_EQ(calibration.even_order[2]->value, 2e-6);
}

TEST(CouplingsOfAFit, SayWhereTheFixtureWasNotStated) {
  const Calibration calibration = make_calibration(model_with_couplings(std::nullopt));
  EXPECT_EQ(calibration.misalignment_uncertainty->standard[0][2], 3e-5);
  EXPECT_TRUE(calibration.misalignment_uncertainty->readings_only);
  EXPECT_TRUE(calibration.even_order[2]->readings_only);
}

TEST(CouplingsOfAFit, SurviveTheModelDocument) {
  const UnitModel model = model_with_couplings(4e-5);
  const auto document = model_document(model);
  ASSERT_TRUE(document);
  const auto read = calibration_of(*document);
  ASSERT_TRUE(read) << read.error().message;
  const Calibration expected = make_calibration(model);
  EXPECT_EQ(read->misalignment_uncertainty, expected.misalignment_uncertainty);
  EXPECT_EQ(read->even_order, expected.even_order);
}

TEST(CouplingsOfAFit, AreNotInDocumentsOfBefore) {
  json document = json::parse(*model_document(model_with_couplings(4e-5)));
  document["calibration"].erase("misalignment_uncertainty");
  document["calibration"].erase("even_order");
  const auto read = calibration_of(document.dump());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->accel_misalignment);
  EXPECT_FALSE(read->misalignment_uncertainty);
  EXPECT_FALSE(read->even_order[2]);
}

TEST(CouplingsInJson, AreThoseOfTheFile) {
  const json document = json::parse(*export_json(golden_couplings()));
  EXPECT_EQ(document["accel_misalignment_uncertainty"]["standard_uncertainty"][1][0], 0x1.8p-13);
  EXPECT_EQ(document["accel_misalignment_uncertainty"]["readings_only"], false);
  EXPECT_NEAR(document["g_sensitivity_uncertainty_dps_per_mps2"]["standard_uncertainty"][0][0].get<double>(),
              0x1p-17 * 180.0 / 3.14159265358979324, 1e-18);
  EXPECT_EQ(document["accel_even_order_per_mps2"]["accel_x"]["value"], -0x1p-18);
  EXPECT_TRUE(document["accel_even_order_per_mps2"]["accel_y"].is_null());
  EXPECT_TRUE(json::parse(*export_json(golden_mixed()))["accel_misalignment_uncertainty"].is_null());
}

}  // namespace
}  // namespace soak::calib
