// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/report_json.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/judge/detail/report_words.h"
#include "tests/errors.h"

namespace soak::calib {
namespace {

/// bias = 1 + 0.5 (T − 0) from 0 to 100 °C
Curve straight_line() { return SplineCurve{{0.0, 100.0}, {{1.0, 0.5, 0.0, 0.0}}}; }

CurveData two_runs() {
  CurveData data;
  data.runs = {"R01", "R02"};
  data.branches = {"R01 up", "R02 up"};
  // Run 0 lies 0.2 above the line, run 1 lies 0.1 below; one row of run 1 is 0.4 further down.
  data.rows = {{0, 0, Sweep::up, 0.0, 10.0, 6.2, 0.01},
               {0, 0, Sweep::up, 1.0, 20.0, 11.2, 0.01},
               {1, 1, Sweep::down, 0.0, 10.0, 5.9, 0.01},
               {1, 1, Sweep::down, 1.0, 20.0, 10.5, 0.01}};
  return data;
}

TEST(ReportRowsTest, ResidualsAreRowsLessTheStoredCurveInPrintedUnits) {
  const ReportRows compared = compare_rows(two_runs(), straight_line(), 10.0, false);
  ASSERT_EQ(compared.rows.size(), 4u);
  // value 6.2 at 10 °C, where the line is 6: 0.2, printed tenfold
  EXPECT_NEAR(compared.rows[0].residual, 2.0, 1e-12);
  EXPECT_NEAR(compared.rows[0].value, 62.0, 1e-12);
  EXPECT_NEAR(compared.rows[0].standard_error, 0.1, 1e-15);
  EXPECT_NEAR(compared.rows[3].residual, -5.0, 1e-12);
  // squares of 0.2 0.2 0.1 0.5, mean 0.34/4
  EXPECT_NEAR(compared.rmse_abs, 10.0 * std::sqrt(0.34 / 4.0), 1e-12);
  EXPECT_NEAR(compared.worst_abs, 5.0, 1e-12);
  EXPECT_EQ(compared.worst_run, "R02");
  EXPECT_EQ(compared.worst_temp_c, 20.0);
}

TEST(ReportRowsTest, ShapeLosesEachRunsOwnMean) {
  const ReportRows compared = compare_rows(two_runs(), straight_line(), 1.0, false);
  EXPECT_NEAR(compared.rows[0].shape_residual, 0.0, 1e-12);
  EXPECT_NEAR(compared.rows[2].shape_residual, 0.2, 1e-12);  // −0.1 less the mean of −0.1 and −0.5
  EXPECT_NEAR(compared.rows[3].shape_residual, -0.2, 1e-12);
  EXPECT_NEAR(compared.rmse_shape, std::sqrt(0.08 / 4.0), 1e-12);
}

TEST(ReportRowsTest, RowsOfARelativeCurveAreShiftedTogether) {
  const ReportRows compared = compare_rows(two_runs(), straight_line(), 1.0, true);
  double sum = 0.0;
  for (const ReportRow& row : compared.rows) sum += row.residual;
  EXPECT_NEAR(sum, 0.0, 1e-12);
  EXPECT_NEAR(compared.rows[0].residual - compared.rows[2].residual, 0.3, 1e-12);  // runs stay apart
  EXPECT_NEAR(compared.rows[0].value - compared.rows[0].residual, 6.0, 1e-12);     // the curve stays where it is
}

TEST(ReportRowsTest, FiguresCountAllRowsWhereOnlySomeAreDrawn) {
  CurveData data;
  data.runs = {"R01"};
  for (int i = 0; i < 5000; ++i) {
    const double temp_c = 0.02 * i;
    data.rows.push_back({0, 0, Sweep::up, 1.0 * i, temp_c, 1.0 + 0.5 * temp_c + (i == 4321 ? 3.0 : 0.0), 0.0});
  }
  const ReportRows compared = compare_rows(data, straight_line(), 1.0, false);
  EXPECT_EQ(compared.total, 5000u);
  EXPECT_EQ(compared.rows.size(), kMostReportRows);
  EXPECT_NEAR(compared.worst_abs, 3.0, 1e-9);
  EXPECT_NEAR(compared.rmse_abs, 3.0 / std::sqrt(5000.0), 1e-9);
  EXPECT_EQ(compared.rows.front().temp_c, 0.0);
  EXPECT_GT(compared.rows.back().temp_c, 99.0);
}

/// The codes in the first column of a table of warnings: between backticks, at the beginning of a line.
std::vector<std::string> codes_in(const std::string& file, const std::string& heading) {
  std::ifstream in(std::string(SOAK_TEST_FOLDER) + "/../docs/" + file);
  std::vector<std::string> codes;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("## ")) inside = line == "## " + heading;
    if (!inside || !line.starts_with("| `")) continue;
    const std::string cell = line.substr(0, std::min(line.find('|', 1), line.find('(')));
    for (std::size_t from = cell.find('`'); from != std::string::npos;) {
      const std::size_t to = cell.find('`', from + 1);
      codes.push_back(cell.substr(from + 1, to - from - 1));
      from = cell.find('`', to + 1);
    }
  }
  return codes;
}

TEST(RemedyTest, EveryDocumentedWarningHasOne) {
  std::vector<std::string> codes = codes_in("fit.md", "Warnings");
  EXPECT_GT(codes.size(), 15u);  // the table was found
  const std::vector<std::string> own = codes_in("report.md", "Warnings of a report");
  EXPECT_GT(own.size(), 5u);
  codes.insert(codes.end(), own.begin(), own.end());
  for (const std::string& code : codes) EXPECT_FALSE(remedy_of(code).empty()) << code;
}

nlohmann::json fit_with_pi95(const nlohmann::json& pi95) {
  return {{"sensors", {{"gyro_x", {{"curve", {{{"temp_c", 0.0}, {"pi95", pi95}}}}}}}}};
}

Verification verification_of(Verdict unit, Verdict sensor, double worst_rps) {
  Verification verification;
  verification.verdict = unit;
  SensorVerification result;
  result.verdict = result.bias_verdict = sensor;
  result.rows = 10;
  result.worst_abs = worst_rps;
  result.worst_temp_c = 34.2;
  result.limit = 0.01;
  verification.sensors[0] = result;
  return verification;
}

TEST(VerdictSentenceTest, WithoutLimitsNothingPasses) {
  const auto verdict =
      verdict_sentence(fit_with_pi95(0.042), false, verification_of(Verdict::info, Verdict::info, 0.0), {"V01"});
  EXPECT_EQ(verdict.verdict, "info");
  EXPECT_NE(verdict.sentence.find("±0.042 deg/s"), std::string::npos);
}

TEST(VerdictSentenceTest, LimitsWithoutFreshRunsAreNotMeasured) {
  const auto verdict = verdict_sentence(fit_with_pi95(nullptr), true, std::nullopt, {});
  EXPECT_EQ(verdict.verdict, "not_measured");
}

TEST(VerdictSentenceTest, AFailureNamesSensorErrorAndLimit) {
  // 0.02 rad/s = 1.1459 deg/s, limit 0.01 rad/s = 0.573 deg/s
  const auto verdict =
      verdict_sentence(fit_with_pi95(0.1), true, verification_of(Verdict::fail, Verdict::fail, 0.02), {"V01", "V02"});
  EXPECT_EQ(verdict.verdict, "fail");
  EXPECT_TRUE(base::mentions(verdict.sentence, {"V01, V02", "gyro_x", "1.15 deg/s", "34.2 °C", "0.573 deg/s"}));
}

TEST(VerdictSentenceTest, APassSaysWhatItRestsOn) {
  const auto verdict =
      verdict_sentence(fit_with_pi95(0.1), true, verification_of(Verdict::pass, Verdict::pass, 0.001), {"V01"});
  EXPECT_EQ(verdict.verdict, "pass");
  EXPECT_NE(verdict.sentence.find("V01"), std::string::npos);
}

}  // namespace
}  // namespace soak::calib
