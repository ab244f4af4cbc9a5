// SPDX-License-Identifier: Apache-2.0
#include "station/report/term_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace soak::station {
namespace {

constexpr double kDeg = 180.0 / std::numbers::pi;

void expect_printed(const calib::TermParameter& given, const std::string& name, double value, const std::string& unit) {
  const calib::TermParameter printed = printed_parameter(given);
  EXPECT_EQ(printed.name, name);
  EXPECT_EQ(printed.unit, unit);
  EXPECT_NEAR(printed.value, value, 1e-12 * std::abs(value));
}

// The units of soak gap find: docs/gap-workflow.md, the library.
TEST(TermText, ParametersHaveTheUnitsInWhichSizesAreTold) {
  expect_printed({"amplitude", 2e-3, "rad/s"}, "amplitude", 2e-3 * kDeg, "deg/s");
  expect_printed({"amplitude_per_c", 2e-3, "rad/s/K"}, "amplitude_per_c", 2e-3 * kDeg, "deg/s/K");
  expect_printed({"per_kps", 3.0, "rad/s/(K/s)"}, "per_kpmin", 3.0 * kDeg / 60.0, "deg/s/(K/min)");
  expect_printed({"per_kps", 3.0, "m/s2/(K/s)"}, "per_kpmin", 0.05, "m/s2/(K/min)");
  expect_printed({"per_kps_per_c", 3.0, "m/s2/(K/s)/K"}, "per_kpmin_per_c", 0.05, "m/s2/(K/min)/K");
  expect_printed({"x", 1e-4, "(rad/s)/(m/s2)"}, "x", 1e-4 * kDeg * 9.80665, "deg/s/g");
  expect_printed({"x", 1e-4, "(m/s2)/(m/s2)"}, "x", 1e-4 * 9.80665, "m/s2/g");
  expect_printed({"even_order", 1e-5, "1/(m/s2)"}, "even_order", 1e-5 * 9.80665 * 9.80665, "m/s2/g2");
  expect_printed({"per_s", 1e-12, "rad/s/s"}, "per_1000h", 1e-12 * kDeg * 3.6e6, "deg/s per 1000 h");
  expect_printed({"per_s", 1e-10, "m/s2/s"}, "per_1000h", 3.6e-4, "m/s2 per 1000 h");
  expect_printed({"x@R1", 1e-3, "rad"}, "x@R1", 1e-3 * kDeg, "deg");
}

TEST(TermText, OtherUnitsStay) {
  expect_printed({"width_c", 6.0, "K"}, "width_c", 6.0, "K");
  expect_printed({"tau_s", 320.0, "s"}, "tau_s", 320.0, "s");
  expect_printed({"amplitude", 0.02, "m/s2"}, "amplitude", 0.02, "m/s2");
  expect_printed({"per_v", 0.02, "m/s2/V"}, "per_v", 0.02, "m/s2/V");
  expect_printed({"x", 1e-6, "rad/K"}, "x", 1e-6, "rad/K");
  expect_printed({"reference_utc_s", 1.7e9, "s"}, "reference_utc_s", 1.7e9, "s");
}

}  // namespace
}  // namespace soak::station
