// SPDX-License-Identifier: Apache-2.0
// The page alone, from documents made up here; tests/cli/test_report.py makes it from a catalog.
#include "station/report/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "station/report/html.h"
#include "tests/errors.h"

namespace soak::station {
namespace {

using nlohmann::json;

TEST(HtmlTest, EscapesWhatHasAMeaning) {
  EXPECT_EQ(html::escaped("a<b>&\"'c"), "a&lt;b&gt;&amp;&quot;&#39;c");
  EXPECT_EQ(html::escaped(std::string_view("x\0y\x1by", 5)), "x\uFFFDy\uFFFDy");
}

TEST(HtmlTest, WritesThreeDigitsForPeople) {
  EXPECT_EQ(html::number_text(0.0), "0");
  EXPECT_EQ(html::number_text(0.0000123456), "0.0000123");
  EXPECT_EQ(html::number_text(-1.234e-7), "−1.23×10⁻⁷");
  EXPECT_EQ(html::number_text(-1234.5), "−1234");
  EXPECT_EQ(html::number_text(9.80665), "9.81");
}

TEST(HtmlTest, KeepsEveryDigitForScripts) {
  EXPECT_EQ(html::number(0.1 + 0.2), "<data value=\"0.30000000000000004\">0.300</data>");
  EXPECT_EQ(html::number(json()), "–");
}

/// The page less the two elements that its own script and the data of that are in.
std::string without_script(std::string page) {
  for (const char* tag : {"<script type=\"application/json\" id=\"data\">", "<script type=\"module\">"}) {
    const std::size_t at = page.find(tag);
    if (at == std::string::npos) return "no script";
    page.erase(at, page.find("</script>", at) + 9 - at);
  }
  return page;
}

/// What the figures are drawn from.
json data_of(const std::string& page) {
  const std::string tag = "id=\"data\">";
  const std::size_t from = page.find(tag) + tag.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

/// Tags that stand open at the end, or the first that closes what is not open; void elements of HTML left out.
std::string unbalanced(const std::string& whole_page) {
  const std::string page = without_script(whole_page);
  static const std::set<std::string> kVoid = {"meta", "link", "br", "!DOCTYPE"};
  std::vector<std::string> open;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    const std::size_t end = page.find('>', at);
    std::string tag = page.substr(at + 1, end - at - 1);
    const bool closes = tag.starts_with('/');
    const bool empty = tag.ends_with('/');
    tag = tag.substr(closes ? 1 : 0, tag.find_first_of(" \n/", 1) - (closes ? 1 : 0));
    if (kVoid.contains(tag) || empty) continue;
    if (!closes) {
      open.push_back(tag);
    } else if (open.empty() || open.back() != tag) {
      return "</" + tag + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : open.back() + " is not closed";
}

json rows(std::size_t runs, std::size_t count) {
  json points = json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i);
    points.push_back({{"run", i % runs},
                      {"sweep", i % 2 == 0 ? "up" : "down"},
                      {"temp_c", std::fmod(x * 7.13, 100.0) - 30.0},
                      {"value", std::sin(x)},
                      {"standard_error", 0.001},
                      {"residual", 0.01 * std::cos(x)},
                      {"shape_residual", 0.001 * std::cos(x)}});
  }
  json labels = json::array();
  for (std::size_t r = 0; r < runs; ++r) labels.push_back("R" + std::to_string(r + 1));
  return {{"runs", labels},    {"total", count},       {"rmse_abs", 0.01},  {"rmse_shape", 0.001},
          {"worst_abs", 0.02}, {"worst_temp_c", 12.0}, {"worst_run", "R1"}, {"points", points}};
}

json curve() {
  json points = json::array();
  for (int t = -30; t <= 70; ++t) {
    points.push_back({{"temp_c", t},
                      {"bias", std::sin(0.05 * t)},
                      {"ci95", 0.01},
                      {"pi95", 0.04},
                      {"scale_ppm", 100.0 + t},
                      {"scale_ci95_ppm", 5.0}});
  }
  return points;
}

/// One sensor of a model from before there was an uncertainty budget.
json sensor(std::size_t runs, std::size_t count) {
  json checks = json::array();
  for (std::size_t r = 0; r < runs; ++r) {
    checks.push_back({{"held_out", "R" + std::to_string(r)},
                      {"anfis", 0.01},
                      {"poly3", 0.02},
                      {"poly5", 0.03},
                      {"spline", nullptr}});
  }
  const json baseline = {{"rmse_abs", 0.02}, {"rmse_shape", 0.01}};
  const json fit = {{"rules", 6},
                    {"membership", "bell"},
                    {"deployed", "anfis"},
                    {"scale_deployed", "poly3"},
                    {"check_rmse", 0.01},
                    {"check_rmse_shape", 0.001},
                    {"run_to_run_sigma", 0.02},
                    {"lack_of_fit_sigma", 0.001},
                    {"holdout", "run"},
                    {"runs", json::array()},
                    {"checks", checks},
                    {"temp_min_c", -30.0},
                    {"temp_max_c", 70.0},
                    {"curve", curve()},
                    {"relative", false},
                    {"baselines", {{"poly3", baseline}, {"poly5", baseline}, {"spline", baseline}}}};
  return {{"unit", "deg/s"},  {"fit", fit},       {"rows", rows(runs, count)},  {"scale_rows", rows(runs, count)},
          {"fresh", nullptr}, {"limit", nullptr}, {"scale_limit_ppm", nullptr}, {"verification", nullptr}};
}

json run(const std::string& label) {
  return {{"label", label},
          {"campaign", "c"},
          {"procedure", "p"},
          {"use", "fitted"},
          {"created_utc_s", 1.8e9},
          {"duration_s", 80000.0},
          {"source", "import a.csv"},
          {"clock_rate", 1.0},
          {"simulated", false},
          {"gravity_mps2", 9.81},
          {"gravity", "known"},
          {"latitude_deg", 48.1},
          {"content_sha256", std::string(64, 'a')},
          {"voids", json::array()}};
}

/// A check standard with twelve campaigns, the last one out of control and of the model.
json check_standards(const std::string& text) {
  json campaigns = json::array();
  for (int i = 0; i < 12; ++i) {
    const json limits = {{"campaigns", i}, {"centre", 0.1}, {"sigma", 0.01}, {"lower", 0.05}, {"upper", 0.15}};
    const bool is_out = i == 11;
    const char* verdict = is_out ? "out_of_control" : i < 10 ? "not_established" : "in_control";
    const json gyro = {{"bias", is_out ? 0.2 : 0.1 + 0.001 * i},
                       {"bias_se", 0.001},
                       {"verdict", verdict},
                       {"limits", i < 10 ? json() : limits},
                       {"last_eight", nullptr}};
    campaigns.push_back({{"campaign", is_out ? text : "c" + std::to_string(i)},
                         {"simulated", false},
                         {"verdict", verdict},
                         {"sensors", {{"gyro_x", gyro}}}});
  }
  const json unit = {{"unit", text}, {"ended", false}, {"campaigns", campaigns}};
  return {{"reference_c", 25.0}, {"campaigns", {text}}, {"units", {unit}}};
}

json document(const std::string& text, std::size_t runs, std::size_t count) {
  json sensors;
  for (const char* name : {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"}) {
    sensors[name] = sensor(runs, count);
  }
  const json warning = {{"code", "few_runs"}, {"text", text}, {"remedy", text}, {"sensors", {"gyro_x"}}};
  const json summary = {{"unit_type", text},    {"epoch", 0},           {"model_created_utc_s", 1.8e9},
                        {"simulated", true},    {"gravity_mps2", 9.81}, {"gravity", "known"},
                        {"verdict", "info"},    {"sentence", text},     {"limits", text},
                        {"warnings", {warning}}};
  json list = json::array();
  for (std::size_t r = 0; r < runs; ++r) list.push_back(run(text));
  const json couplings = {{"accel_misalignment_rad", nullptr}, {"g_sensitivity_dps_per_g", nullptr}};
  const json reference = {{"kind", "level"},
                          {"name", text},
                          {"certificate", text},
                          {"standard_uncertainty", 0.1},
                          {"unit", "deg"},
                          {"due_utc", "2027-01-01"},
                          {"since", "retired: " + text},
                          {"waiver", {{"signer", text}, {"reason", text}, {"signed_utc", "2026-11-22"}}}};
  return {{"unit", text},
          {"model", 3},
          {"created_utc_s", 1.8e9},
          {"software", "soak"},
          {"sections",
           {{"summary", summary},
            {"sensors", sensors},
            {"couplings", couplings},
            {"noise", {{"segment", nullptr}, {"sensors", json::object()}, {"reason", text}}},
            {"check_standards", check_standards(text)},
            {"records", {{"references", {reference}}}},
            {"provenance", {{"model_sha256", std::string(64, 'b')}, {"runs", list}}}}}};
}

TEST(ReportPageTest, IsBalancedAndLoadsNothing) {
  const std::string page = report_page(document("SN1", 3, 40));
  EXPECT_EQ(unbalanced(page), "");
  EXPECT_EQ(without_script(page).find("<script"), std::string::npos);
  EXPECT_EQ(without_script(page).find("://"), std::string::npos);    // no address anywhere
  EXPECT_EQ(page.find("://"), page.find("://www.w3.org/2000/svg"));  // the name of a format, not an address
  EXPECT_EQ(page.find("\nimport "), std::string::npos);
  EXPECT_EQ(page.find("\nexport "), std::string::npos);
  EXPECT_NE(page.find("script-src 'sha256-"), std::string::npos);
  EXPECT_NE(page.find("SIMULATED DATA"), std::string::npos);
  EXPECT_NE(page.find("<title>SIMULATED: "), std::string::npos);
}

TEST(ReportPageTest, TextsFromOutsideStayText) {
  const std::string hostile = "</title><script>alert(1)</script><img src=x onerror=alert(2)>\"'&";
  const std::string page = report_page(document(hostile, 2, 5));
  EXPECT_EQ(unbalanced(page), "");
  EXPECT_EQ(without_script(page).find("<script"), std::string::npos);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(1)"), std::string::npos);
}

TEST(ReportPageTest, StaysSmallWithTwentyRuns) {
  // 1000 rows of bias and of scale for each of six sensors: the most that a document holds.
  EXPECT_LT(report_page(document("SN1", 20, 1000)).size(), 1'500'000u);
}

TEST(ReportPageTest, HoldsWhatItsFiguresAreDrawnFrom) {
  const json data = data_of(report_page(document("SN1", 3, 40)));
  const json& gyro = data["sensors"]["gyro_x"];
  EXPECT_EQ(gyro["curve"]["bias"].size(), 101u);
  EXPECT_NEAR(gyro["curve"]["bias"][0].get<double>(), std::sin(-1.5), 1e-8);
  EXPECT_EQ(gyro["rows"]["points"]["residual"].size(), 40u);
  EXPECT_TRUE(gyro["fresh"].is_null());
}

TEST(ReportPageTest, OlderModelsDoNotStateABudget) {
  EXPECT_EQ(report_page(document("SN1", 3, 10)).find("class=\"basis\""), std::string::npos);
}

TEST(ReportPageTest, ShowsTheCheckStandardsOfItsCampaigns) {
  json with = document("SN1", 3, 10);
  const std::string page = report_page(with);
  EXPECT_NE(page.find("<p>Campaign SN1: <b>OUT OF CONTROL</b>"), std::string::npos);
  EXPECT_TRUE(base::mentions_in_order(page, {"12 campaigns", "1 of them"}));
  EXPECT_NE(page.find("data-chart=\"check\" data-of=\"gyro_x\""), std::string::npos);
  const json drawn = data_of(page)["check"][0];
  EXPECT_EQ(drawn["reference_c"], 25.0);
  EXPECT_EQ(drawn["campaigns"].size(), 12u);
  EXPECT_EQ(drawn["campaigns"][11]["of_model"], true);
  EXPECT_EQ(drawn["campaigns"][10]["of_model"], false);
  EXPECT_NE(page.find("1 % of campaigns"), std::string::npos);
  with["sections"]["check_standards"]["units"] = json::array();
  const std::string without = report_page(with);
  EXPECT_EQ(without.find("data-chart=\"check\""), std::string::npos);
  EXPECT_EQ(unbalanced(without), "");
}

TEST(ReportPageTest, KeepsTheVerdictOnTheBiasApartFromThatOfTheSensor) {
  json with = document("SN1", 3, 10);
  json& gyro = with["sections"]["sensors"]["gyro_x"];
  const json bias = {{"verdict", "pass"},      {"limit", 0.1},          {"rows", 11},         {"worst_abs", 0.01},
                     {"worst_temp_c", 20.0},   {"rmse_abs", 0.01},      {"rmse_shape", 0.01}, {"guard", 0.01},
                     {"inside_pi95", nullptr}, {"inside_ci95", nullptr}};
  json scale = bias;
  scale["verdict"] = "fail";
  gyro["limit"] = 0.1;
  gyro["scale_limit_ppm"] = 100.0;
  gyro["verification"] = {{"verdict", "fail"}, {"bias", bias}, {"scale", scale}};
  EXPECT_TRUE(base::mentions_in_order(report_page(with), {"data-heading=\"bias verdict\">pass</td><td class=\"fail\" "
                                                          "data-heading=\"scale verdict\">fail</td>"}));
  gyro["fit"]["scale_deployed"] = nullptr;
  gyro["verification"] = {{"verdict", "pass"}, {"bias", bias}, {"scale", nullptr}};
  EXPECT_TRUE(base::mentions_in_order(report_page(with), {"data-heading=\"bias verdict\">pass</td><td class=\"nowrap\" "
                                                          "data-heading=\"scale verdict\">scale not known</td>"}));
}

TEST(ReportPageTest, StatesTheExpandedUncertaintyWithItsFactorAndSaysWhatAFewErrorsInsideTheBandMean) {
  json with = document("SN1", 3, 10);
  const json bias = {{"verdict", "pass"},    {"limit", 0.1},          {"rows", 11},         {"worst_abs", 0.01},
                     {"worst_temp_c", 20.0}, {"rmse_abs", 0.01},      {"rmse_shape", 0.01}, {"guard", 0.012},
                     {"guard_factor", 2.31}, {"inside_pi95", 0.1512}, {"inside_ci95", 1.0}};
  json& gyro = with["sections"]["sensors"]["gyro_x"];
  gyro["limit"] = 0.1;
  gyro["verification"] = {{"verdict", "pass"}, {"bias", bias}, {"scale", nullptr}};
  std::string page = report_page(with);
  EXPECT_NE(page.find("± <data value=\"0.012\">0.0120</data> (k = 2.31)"), std::string::npos);
  EXPECT_NE(page.find("of which 95 % are expected"), std::string::npos);
  gyro["verification"]["bias"]["inside_pi95"] = 0.97;
  EXPECT_EQ(report_page(with).find("of which 95 % are expected"), std::string::npos);
}

TEST(ReportPageTest, WhereNoVerdictHoldsNoSensorPasses) {
  json with = document("SN1", 3, 10);
  with["sections"]["summary"]["no_verdict"] = "the unit was repaired or changed after this model";
  for (auto& [name, sensor] : with["sections"]["sensors"].items()) {
    sensor["limit"] = 0.1;
    sensor["verification"] = {{"verdict", "pass"}, {"bias", {{"verdict", "pass"}}}, {"scale", nullptr}};
    sensor["verification"]["bias"]["worst_abs"] = nullptr;
  }
  const std::string page = report_page(with);
  EXPECT_EQ(page.find("class=\"pass\""), std::string::npos);
  EXPECT_NE(page.find("data-heading=\"bias verdict\">not judged</td>"), std::string::npos);
}

TEST(ReportPageTest, TheCertificateSaysWhoVerifiedAndReleasedAndLeavesLinesToBeFilledIn) {
  json with = document("<b>", 3, 10);
  json& release = with["sections"]["release"];
  release = {{"state", "released"},
             {"verification", {{"utc_s", 1.8e9}, {"user", "a&b"}, {"verdict", "pass"}, {"campaign", "check"}}},
             {"released", {{"utc_s", 1.8e9}, {"user", "eva"}}},
             {"expires_utc_s", 1.9e9},
             {"obstacles", json::array()}};
  EXPECT_TRUE(base::mentions_in_order(
      report_page(with), {"Laboratory", "class=\"fill\"", "&lt;b&gt;, model 3, 2027-01-15", "Verified",
                          "2027-01-15 by a&amp;b, with campaign check: PASS", "Released", "2027-01-15 by eva</dd>",
                          "2030-03-17", "Place and date", "Signature", "class=\"fill\""}));
  release["obstacles"] = {"it was never verified: 'soak verify --unit SN1 --campaign NAME'", "more: fit again"};
  const std::string page = report_page(with);
  EXPECT_NE(page.find("Not to be handed over any more: it was never verified, and 1 more"), std::string::npos);
  EXPECT_EQ(page.find("soak verify"), std::string::npos);
}

TEST(ReportPageTest, OnlyWhatMayBeHandedOverIsValidUntilADay) {
  json with = document("SN1", 3, 10);
  json& release = with["sections"]["release"];
  release = {{"state", "released"},
             {"verification", nullptr},
             {"released", {{"utc_s", 1.8e9}, {"user", "eva"}}},
             {"expires_utc_s", 1.9e9},
             {"obstacles", json::array()}};
  const auto names_the_day = [&] { return report_page(with).find("2030-03-17") != std::string::npos; };
  EXPECT_TRUE(names_the_day());
  release["obstacles"] = {"its last verification, against campaign 'check', says fail, not pass: fit again"};
  EXPECT_FALSE(names_the_day());
  for (const char* state : {"fitted", "verified", "withdrawn"}) {
    release["state"] = state;
    EXPECT_FALSE(names_the_day()) << state;
  }
}

TEST(ReportPageTest, EveryPrintedPageHasTheNumberOfTheCertificateAndItsOwn) {
  const std::string page = report_page(document("A\"}</style>", 3, 10));
  EXPECT_NE(page.find("A\\22 \\7d \\3c \\2f style\\3e "), std::string::npos);
  EXPECT_NE(page.find("counter(page)"), std::string::npos);
  EXPECT_EQ(unbalanced(page), "");
}

TEST(ReportPageTest, TheCertificateHasTheGravestWarningsAndTheRestComesBehind) {
  json with = document("SN1", 3, 10);
  json warnings = json::array();
  for (int i = 0; i < 9; ++i) {
    warnings.push_back({{"code", "few_runs"},
                        {"text", "trouble " + std::to_string(i)},
                        {"remedy", "mend it"},
                        {"urgency", i == 0 ? "grave" : "act"},
                        {"sensors", json::array()}});
  }
  with["sections"]["summary"]["warnings"] = warnings;
  const std::string page = report_page(with);
  EXPECT_TRUE(base::mentions_in_order(
      page, {"class=\"certificate\"", "NOT JUDGED", "Verdict, sensor by sensor", "<li class=\"grave\">", "trouble 0",
             "trouble 5", "And 3 more", "<nav", "More warnings", "trouble 6", "trouble 8"}));
  EXPECT_EQ(unbalanced(page), "");
}

/// A warning as the document has it.
json warning_of(const std::string& code, const std::string& text, const std::string& urgency, const json& sensors) {
  return {{"code", code}, {"text", text}, {"remedy", "No action needed."}, {"urgency", urgency}, {"sensors", sensors}};
}

TEST(ReportPageTest, CountsTheCurvesThatWereTakenInsteadOfAnAnfisByTheirWarnings) {
  const std::string few = "is deployed; so few runs are no judge when held out";
  json with = document("SN1", 3, 10);
  // The scale of all sensors is poly3 in document(); without a warning none of them met an ANFIS.
  with["sections"]["summary"]["warnings"] = {
      warning_of("baseline_deployed", "gyro_x: spline beats the ANFIS", "none", {"gyro_x"}),
      warning_of("baseline_deployed", "gyro_x scale: poly5 beats the ANFIS", "none", {"gyro_x"}),
      warning_of("baseline_deployed", "accel_x: poly3 " + few, "none", {"accel_x"}),
      warning_of("baseline_deployed", "accel_y: poly3 " + few, "none", {"accel_y"})};
  EXPECT_NE(
      report_page(with).find("Nothing to do: better than the ANFIS and in the file: 1 polynomial, 1 spline; in the "
                             "file for the least expected error, so few runs are no judge when held out: 2 "
                             "polynomial.</p>"),
      std::string::npos);
  with["sections"]["summary"]["warnings"] = json::array();
  EXPECT_EQ(report_page(with).find("Nothing to do"), std::string::npos);
}

TEST(ReportPageTest, AdviceOnWhatAsksForNothingStaysBehindTheCertificate) {
  json with = document("SN1", 3, 10);
  json spikes = warning_of("spike", "3 samples stand alone", "none", {"gyro_x"});
  spikes["remedy"] = "No action needed; look at the cable.";
  with["sections"]["summary"]["warnings"] = {spikes,
                                             warning_of("rate_positions", "no six positions", "none", json::array())};
  const std::string page = report_page(with);
  EXPECT_TRUE(base::mentions_in_order(page, {"Nothing to do: gyro_x: 3 samples stand alone; no six positions.</p>",
                                             "<nav", "More warnings", "3 samples stand alone", "look at the cable"}));
  EXPECT_EQ(page.find("no six positions", page.find("More warnings")), std::string::npos) << "all of it has been said";
}

TEST(ReportPageTest, LongWarningsAreCutBetweenCharactersAndWholeBehindTheCertificate) {
  json with = document("SN1", 3, 10);
  std::string umlauts = "x";
  for (int i = 0; i < 200; ++i) umlauts += "ü";
  with["sections"]["summary"]["warnings"] = {warning_of("hysteresis", umlauts + " act", "act", json::array()),
                                             warning_of("rate_positions", umlauts + " none", "none", json::array())};
  const std::string page = report_page(with);  // json refuses what is no UTF-8
  EXPECT_NO_THROW((void)json(page).dump());
  EXPECT_TRUE(base::mentions_in_order(
      page, {"ü… <code>hysteresis", "Nothing to do: x", "ü….</p>", "More warnings", "ü act", "ü none"}));
}

TEST(ReportPageTest, TheReportOfACampaignMarksWhatIsSimulatedUnitByUnit) {
  const auto line = [](const char* unit, bool simulated) {
    return json{{"unit", unit},      {"model", 3},       {"fitted_utc_s", 1.8e9}, {"simulated", simulated},
                {"verdict", "pass"}, {"sentence", "ok"}, {"trouble", nullptr}};
  };
  json real = document("REAL", 2, 5);
  real["sections"]["summary"]["simulated"] = false;
  const CampaignReport report{{{"campaign", "c"},
                               {"created_utc_s", 1.8e9},
                               {"software", "soak"},
                               {"units", {line("REAL", false), line("SIM", true)}}},
                              {real, document("SIM", 2, 5)}};
  const std::string page = campaign_page(report);
  EXPECT_TRUE(base::mentions_in_order(page, {"<title>Calibration report", "measured", "<b>SIMULATED</b>",
                                             "<h2>Unit REAL", "<h2>Unit SIM", "SIMULATED DATA"}));
  EXPECT_EQ(page.find("SIMULATED DATA"), page.rfind("SIMULATED DATA"));
  EXPECT_EQ(page.find("class=\"watermark\""), std::string::npos);
}

TEST(ReportPageTest, TheReportOfACampaignKeepsTextsAsText) {
  const std::string hostile = "</title><script>alert(1)</script><img src=x onerror=alert(2)>\"'&";
  json line = {{"unit", hostile},   {"model", 3},          {"fitted_utc_s", 1.8e9}, {"simulated", true},
               {"verdict", "fail"}, {"sentence", hostile}, {"trouble", nullptr}};
  json without = {{"unit", hostile},    {"model", nullptr},    {"fitted_utc_s", nullptr}, {"simulated", nullptr},
                  {"verdict", nullptr}, {"sentence", nullptr}, {"trouble", hostile}};
  CampaignReport report{
      {{"campaign", hostile}, {"created_utc_s", 1.8e9}, {"software", "soak"}, {"units", {line, without}}},
      {document(hostile, 2, 5), json()}};
  const std::string page = campaign_page(report);
  EXPECT_EQ(unbalanced(page), "");
  EXPECT_EQ(without_script(page).find("<script"), std::string::npos);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_TRUE(base::mentions_in_order(page, {"2 units: 1 fail, 1 no report.", "href=\"#unit-1\"", "id=\"unit-1\""}));
  EXPECT_EQ(page.find("id=\"unit-2\""), std::string::npos);
}

TEST(ReportPageTest, DrawsTheUncertaintyBudget) {
  json with = document("SN1", 3, 10);
  const json spread = {{"max", 0.0123}, {"at_25c", 0.0111}};
  const json none = {{"max", nullptr}, {"at_25c", nullptr}};
  with["sections"]["sensors"]["gyro_x"]["fit"]["uncertainty"] = {
      {{"name", "run_to_run"},
       {"type", "A"},
       {"degrees_of_freedom", 2.0},
       {"stated", true},
       {"curve", spread},
       {"fresh_power_on", spread},
       {"basis", "scatter of 3 runs"}},
      {{"name", "fixture"},
       {"type", "B"},
       {"degrees_of_freedom", nullptr},
       {"stated", false},
       {"curve", none},
       {"fresh_power_on", none},
       {"basis", "no reference <entered> ('soak reference add --kind level')"}}};
  const std::string page = report_page(with);
  EXPECT_EQ(page.find("soak reference"), std::string::npos) << "a customer has no terminal of the station";
  EXPECT_EQ(page.find(">deg/s"), std::string::npos);
  EXPECT_NE(page.find("<data value=\"0.0123\">0.0123</data>"), std::string::npos);
  EXPECT_NE(page.find("class=\"basis\""), std::string::npos);
  EXPECT_NE(page.find("scatter of 3 runs"), std::string::npos);
  EXPECT_NE(page.find("∞"), std::string::npos);
  EXPECT_NE(page.find("<td class=\"nowrap\">not stated</td>"), std::string::npos);
  EXPECT_NE(page.find("no reference &lt;entered&gt;"), std::string::npos);
  with["sections"]["sensors"]["gyro_x"]["fit"]["scale_uncertainty"] = {{{"name", "gravity"},
                                                                        {"type", "B"},
                                                                        {"degrees_of_freedom", nullptr},
                                                                        {"stated", false},
                                                                        {"curve", none},
                                                                        {"fresh_power_on", none},
                                                                        {"basis", "of the scale"}}};
  const std::string scale = report_page(with);
  const std::string cell = "<td class=\"nowrap\">";
  EXPECT_NE(scale.find(cell + "not stated</td>" + cell + "not stated</td>" + cell + "–</td>" + cell +
                       "–</td><td class=\"basis\">of the scale"),
            std::string::npos)
      << "the scale has no band of a fresh power-on";
  EXPECT_EQ(unbalanced(page), "");
}

}  // namespace
}  // namespace soak::station
