// SPDX-License-Identifier: Apache-2.0
// Rates of the fixture: what a procedure may ask for, the steps that it becomes, the rows that are recorded of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "run_recorder_bench.h"
#include "station/config/plan.h"
#include "station/lab/start_check.h"

namespace soak::station {
namespace {

std::string procedure(const std::string& rates, const std::string& kind = "soak") {
  return "name = \"r\"\npurpose = \"calibration\"\nkind = \"" + kind +
         "\"\n[temperatures]\nlist_c = [0, 40]\n[positions]\norder = [\"+Z\", \"-Z\"]\nbetween_runs = \"same\"\n"
         "[preflight]\nposition_s = 0\n[rates]\n" +
         rates;
}

std::string refusal(const std::string& text) {
  const auto read = parse_procedure(text, "p.toml");
  return read ? "" : read.error().message;
}

TEST(Rates, EndEachVisitInThePositionsThatAreNamed) {
  const auto read = parse_procedure(procedure("positions = [\"-z\"]\nlist_dps = [60, -60]\ndwell_s = 30\n"), "p.toml");
  ASSERT_TRUE(read) << read.error().message;
  const Plan plan = compile_plan(*read);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    if (plan.steps[i].visit == 0)
      lines.push_back(describe(plan, i).substr(std::string("R01 visit 0, +0 °C down: ").size()));
  }
  EXPECT_EQ(lines, (std::vector<std::string>{
                       "turn to +Z", "drive the chamber to the set point", "wait until settled, at most 7200 s",
                       "record 600 s at +Z", "turn to -Z", "wait until settled after the turn, at most 7200 s",
                       "record 600 s at -Z", "turn to -Z", "wait until settled after the turn, at most 7200 s",
                       "rotate at +60 deg/s in -Z", "record 30 s at -Z, +60 deg/s", "rotate at -60 deg/s in -Z",
                       "record 30 s at -Z, -60 deg/s", "stop the rotation"}));
  // Where it comes to rest it is in no position: the next visit turns it to its first one.
  const auto next = std::ranges::find_if(plan.steps, [](const Step& step) { return step.visit == 1; });
  ASSERT_NE(next, plan.steps.end());
  EXPECT_EQ(next->kind, StepKind::move);
  EXPECT_EQ(next->position, "+Z");
  const auto document = plan_document(plan);
  EXPECT_EQ(document["steps"][10]["rate_dps"], 60.0);
  EXPECT_EQ(document["steps"][10]["kind"], "spin");
  EXPECT_FALSE(document["steps"][1].contains("rate_dps"));
}

TEST(Rates, AreRefusedWithTheKeyOrValueThatIsWrong) {
  std::string ramp = procedure("positions = [\"+Z\"]\nlist_dps = [60]\n", "ramp");
  ramp.replace(ramp.find("[\"+Z\", \"-Z\"]"), 12, "[\"+Z\"]");
  const std::vector<std::pair<std::string, std::string>> mistakes = {
      {procedure("positions = [\"+X\"]\nlist_dps = [60]\n"), "'+X'"},
      {procedure("positions = [\"+Z\", \"+Z\"]\nlist_dps = [60]\n"), "'+Z'"},
      {procedure("positions = []\nlist_dps = [60]\n"), "'rates.positions'"},
      {procedure("positions = [\"+Z\"]\nlist_dps = [60, 1]\n"), "1 deg/s"},
      {procedure("positions = [\"+Z\"]\nlist_dps = [60, 60]\n"), "60 deg/s"},
      {procedure("positions = [\"+Z\"]\nlist_dps = []\n"), "'rates.list_dps'"},
      {procedure("positions = [\"+Z\"]\n"), "'rates.list_dps'"},
      {ramp, "[rates]"}};
  for (const auto& [text, part] : mistakes) {
    EXPECT_NE(refusal(text).find(part), std::string::npos) << part << ": " << refusal(text);
  }
}

/// A fixture that spins about its z axis; nobody asks it for more.
class Spinner : public hal::Fixture {
 public:
  base::Status connect() override { return {}; }
  std::vector<std::string> positions() const override { return {"+Z", "-Z"}; }
  base::Status move_to(std::string_view /*label*/) override { return {}; }
  base::Result<hal::FixtureReading> read() override { return hal::FixtureReading{}; }
  std::string description() const override { return "the spinner"; }
  base::Status can_spin(std::string_view label, double /*rate_dps*/) const override {
    return label == "+Z" ? base::Status{} : base::bad_input("not so");
  }
};

std::string start_refusal(const std::string& text, const hal::Fixture* fixture, double range_dps = 450.0) {
  const auto read = parse_procedure(text, "p.toml");
  if (!read) return read.error().message;
  calib::UnitType type;
  type.gyro_range_dps = range_dps;
  const auto able = check_fixture({compile_plan(*read), {{Slot{}, "SN1", type}}}, fixture);
  return able ? "" : able.error().message;
}

TEST(Rates, AreCheckedAgainstFixtureAndUnitsBeforeTheStart) {
  const Spinner spinner;
  const std::string rates = procedure("positions = [\"+Z\"]\nlist_dps = [400, -400]\n");
  EXPECT_EQ(start_refusal(rates, &spinner), "");
  const std::string too_fast = start_refusal(rates, &spinner, 420.0);
  for (const char* part : {"400 deg/s", "SN1", "420 deg/s"}) EXPECT_NE(too_fast.find(part), std::string::npos) << part;
  EXPECT_NE(start_refusal(rates, nullptr), "");
  EXPECT_NE(start_refusal(procedure("positions = [\"-Z\"]\nlist_dps = [60]\n"), &spinner), "");
  std::string lying = procedure("positions = [\"+Z\"]\nlist_dps = [60]\n");
  lying.replace(lying.find("\"-Z\""), 4, "\"+X\"");
  const std::string unknown = start_refusal(lying, &spinner);
  for (const char* part : {"position +X", "+Z, -Z"}) EXPECT_NE(unknown.find(part), std::string::npos) << unknown;
}

using recorder_bench::RunRecorderTest;
using recorder_bench::Unit;

TEST_F(RunRecorderTest, RatesInOnePositionAreSegmentsOfTheirOwnAndWithdrawnOneByOne) {
  auto begun = RunRecorder::begin(*catalog_, info(), "calibration", {{"SN1", "mti"}}, true);
  ASSERT_TRUE(begun) << begun.error().message;
  Unit unit(8);
  ASSERT_TRUE(begun->add(0, unit.samples(40, 30.0F), {calib::Phase::ramp, calib::Sweep::up, 30.0, "", 0}));
  for (const double rate_dps : {0.0, 60.0, 60.0, -60.0}) {
    const bool first_at_rate = rate_dps == 60.0 && begun->rejected() == 0;
    RowLabels recording{calib::Phase::soak, calib::Sweep::up, 30.0, "+Z", 0};
    recording.rate_dps = rate_dps;
    ASSERT_TRUE(begun->add(0, unit.samples(100, 30.0F), recording));
    if (first_at_rate) begun->reject(0, "samples were missing");
    ASSERT_TRUE(begun->add(0, unit.samples(5, 30.0F), {calib::Phase::ramp, calib::Sweep::up, 30.0, "", 0}));
  }
  const auto runs = begun->finish();
  ASSERT_TRUE(runs) << runs.error().message;
  const auto left = catalog_->segments(runs->front().run_id, "SN1", false);
  ASSERT_TRUE(left);
  std::vector<std::string> names;
  for (const auto& segment : *left) {
    names.push_back(segment.key.position + " #" + std::to_string(segment.key.attempt));
    const double expected_dps = segment.key.position == "+Z"               ? 0.0
                                : segment.key.position == "+Z at 60 deg/s" ? 60.0
                                                                           : -60.0;
    EXPECT_NEAR(segment.position->rate_dps.value_or(0.0), expected_dps, 1e-9) << "it goes through rad/s";
  }
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"+Z #0", "+Z at -60 deg/s #0", "+Z at 60 deg/s #1"}));
}

}  // namespace
}  // namespace soak::station
