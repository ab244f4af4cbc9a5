// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "calib/judge/stability.h"
#include "tests/errors.h"

namespace soak::station {
namespace {

const std::filesystem::path kProcedures = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures";

constexpr const char* kShort = R"(name = "short"
purpose = "calibration"
kind = "soak"
[temperatures]
list_c = [0, 20]
[positions]
order = ["+X", "-X"]
)";

Procedure shipped(const std::string& name) {
  const auto procedure = read_procedure(kProcedures / (name + ".toml"));
  EXPECT_TRUE(procedure) << procedure.error().where << ": " << procedure.error().message;
  return procedure.value_or(Procedure{});
}

/// The refusal of the short procedure with one line put in after its line `after` (counted from 1) or, without a text,
/// that line left out.
base::Error refusal(int after, const std::string& line) {
  std::istringstream lines(kShort);
  std::string text;
  std::string row;
  for (int i = 1; std::getline(lines, row); ++i) {
    if (i != after || !line.empty()) text += row + "\n";
    if (i == after && !line.empty()) text += line + "\n";
  }
  const auto procedure = parse_procedure(text, "p.toml");
  EXPECT_FALSE(procedure) << text;
  return procedure ? base::Error{} : procedure.error();
}

TEST(Procedure, TheThesisProcedureHasTheThesisNumbers) {
  // Seed notes, chapter 6: 21 plateaus from -30 to +70 °C, six positions of ten minutes, 20 runs. Ours begin and end at
  // the reference plateau.
  const Procedure p = shipped("six-position-soak");
  ASSERT_EQ(p.set_points_c.size(), 23u);
  for (std::size_t i = 0; i < 21; ++i) EXPECT_EQ(p.set_points_c[i + 1], -30.0 + 5.0 * static_cast<double>(i));
  EXPECT_EQ(p.set_points_c.front(), 25.0);
  EXPECT_EQ(p.set_points_c.back(), 25.0);
  EXPECT_EQ(p.runs, 20);
  EXPECT_EQ(p.positions.size(), 6u);
  EXPECT_EQ(p.dwell_s, 600.0);
  EXPECT_NE(p.description.find("hysteresis is not measured"), std::string::npos);
}

TEST(Procedure, UpAndDownVisitsTheTurningPlateauOnce) {
  const Procedure p = shipped("six-position-both-ways");
  ASSERT_EQ(p.set_points_c.size(), 43u);
  EXPECT_EQ(std::count(p.set_points_c.begin(), p.set_points_c.end(), 70.0), 1);
  for (std::size_t i = 0; i < 43; ++i) EXPECT_EQ(p.set_points_c[i], p.set_points_c[42 - i]);
}

/// The set points of a procedure with the list and a reference plateau, or what it is refused for.
base::Result<std::vector<double>> with_reference(const std::string& list, const std::string& reference,
                                                 const std::string& kind = "soak") {
  const auto p = parse_procedure(fmt::format("name = \"n\"\npurpose = \"calibration\"\nkind = \"{}\"\n[temperatures]\n"
                                             "list_c = {}\n[reference]\n{}\n[positions]\norder = [\"+Z\"]\n",
                                             kind, list, reference),
                                 "p.toml");
  if (!p) return base::forward_error(p);
  EXPECT_EQ(p->reference_c.has_value(), true);
  return p->set_points_c;
}

TEST(Procedure, AReferencePlateauStandsAtBothEndsOfARun) {
  using Points = std::vector<double>;
  EXPECT_EQ(with_reference("[0, 40]", "temp_c = 25").value(), (Points{25, 0, 40, 25}));
  EXPECT_EQ(with_reference("[-10, 25, 50]", "temp_c = 25.0").value(), (Points{25, -10, 25, 50, 25}));
  // An end that is there already is not visited twice.
  EXPECT_EQ(with_reference("[24, 0, 40]", "temp_c = 24").value(), (Points{24, 0, 40, 24}));
  EXPECT_EQ(with_reference("[24, 0, 24]", "temp_c = 24").value(), (Points{24, 0, 24}));
  EXPECT_FALSE(parse_procedure(kShort, "p.toml")->reference_c);
}

TEST(Procedure, AReferencePlateauIsNear25DegreesAndOfASoakWithOtherSetPoints) {
  for (const auto& refused :
       {with_reference("[0, 40]", "temp_c = 22.4"), with_reference("[0, 40]", "temp_c = 27.6"),
        with_reference("[0, 40]", "temp_c = \"room\""), with_reference("[25, 24]", "temp_c = 25"),
        with_reference("[0, 40]", "temp_c = 25", "ramp"), with_reference("[0]", "temp_c = 25", "rest")}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "p.toml:7") << refused.error().message;
  }
  const auto missing = with_reference("[0, 40]", "");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("temp_c"), std::string::npos) << missing.error().message;
}

TEST(Procedure, VerificationStandsBetweenThePlateaus) {
  for (const char* name : {"verification", "verification-demo"}) {
    const Procedure p = shipped(name);
    EXPECT_EQ(p.purpose, Purpose::verification);
    EXPECT_EQ(p.set_points_c.front(), -27.5);
    EXPECT_EQ(p.set_points_c.back(), 67.5);
    EXPECT_EQ(p.set_points_c.size(), 20u);
  }
}

TEST(Procedure, EveryShippedFileIsSoundAndNamedLikeItsFile) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kProcedures)) {
    if (entry.path().extension() != ".toml") continue;
    ++files;
    EXPECT_EQ(shipped(entry.path().stem().string()).name, entry.path().stem().string());
  }
  EXPECT_GE(files, 7);
}

TEST(Procedure, EveryShippedFileWaitsWithTheConfidenceThatStabilityIsTestedWith) {
  // tests/calib/stability_test.cpp shows for this one that no unit counts as settled while its truth moves by more than
  // 0.02 K/min.
  const calib::StabilityCriterion tested;
  for (const auto& entry : std::filesystem::directory_iterator(kProcedures)) {
    if (entry.path().extension() != ".toml") continue;
    const StabilitySettings& settings = shipped(entry.path().stem().string()).stability;
    EXPECT_EQ(settings.confidence, tested.confidence) << entry.path();
    EXPECT_LE(settings.slope_kpmin, tested.slope_kpmin) << entry.path();
  }
  EXPECT_EQ(StabilitySettings{}.confidence, tested.confidence);
}

TEST(Procedure, SaysHowLongASuspensionLastsAndWhetherANewDaemonGoesOn) {
  const auto plain = parse_procedure(kShort, "p.toml");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->give_up_h, 12.0);
  EXPECT_EQ(plain->on_restart, RestartOutcome::wait);
  const auto stated =
      parse_procedure("on_restart = \"resume\"\n" + std::string(kShort) + "[suspend]\ngive_up_h = 2.5\n", "p.toml");
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->give_up_h, 2.5);
  EXPECT_EQ(stated->on_restart, RestartOutcome::resume);
  EXPECT_FALSE(parse_procedure(std::string(kShort) + "[suspend]\ngive_up_h = 0.0\n", "p.toml"));
  EXPECT_FALSE(parse_procedure("on_restart = \"maybe\"\n" + std::string(kShort), "p.toml"));
}

TEST(Procedure, AShortFileHasTheDocumentedDefaults) {
  const auto p = parse_procedure(kShort, "p.toml");
  ASSERT_TRUE(p) << p.error().message;
  EXPECT_EQ(p->set_points_c, (std::vector<double>{0.0, 20.0}));
  EXPECT_EQ(p->runs, 1);
  EXPECT_EQ(p->dwell_s, 600.0);
  EXPECT_FALSE(p->ramp_rate_kpmin);
  EXPECT_EQ(p->stability.slope_kpmin, 0.02);
  EXPECT_EQ(p->stability.on_timeout, TimeoutOutcome::skip_plateau);
  EXPECT_EQ(p->end_c, 25.0);
}

TEST(Procedure, EveryMistakeIsReportedWithItsLine) {
  const auto p = parse_procedure(R"(name = "bad"
purpose = "fun"
kind = "soak"
runs = 0
[temperatures]
start_c = -30
stop_c = 70
step_c = 7
sweep = "up"
[positions]
order = ["+X", "+Q", "+X"]
dwel_s = 60
[end]
temp_c = 10
)",
                                 "bad.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().kind, base::ErrorKind::bad_input);
  const std::string& message = p.error().message;
  for (const char* found : {"bad.toml:2: ", "bad.toml:4: ", "bad.toml:8: ", "bad.toml:11: '+Q'", "; '+X'",
                            "bad.toml:12: ", "'dwel_s'", "bad.toml:14: "}) {
    EXPECT_NE(message.find(found), std::string::npos) << found << "\n" << message;
  }
}

TEST(Procedure, ASyntaxErrorNamesItsLine) {
  const auto p = parse_procedure("name = \"x\"\nkind = \n", "p.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().where, "p.toml:2");
}

struct Mistake {
  int after;
  const char* line;
  const char* where;
  const char* says;
};

class OneMistake : public ::testing::TestWithParam<Mistake> {};

TEST_P(OneMistake, IsRefusedAtItsLine) {
  const base::Error error = refusal(GetParam().after, GetParam().line);
  EXPECT_EQ(error.where, GetParam().where);
  EXPECT_NE(error.message.find(GetParam().says), std::string::npos) << error.message;
}

// Lines of the short procedure: 1 name, 2 purpose, 3 kind, 4 [temperatures], 5 list_c, 6 [positions], 7 order.
INSTANTIATE_TEST_SUITE_P(Procedure, OneMistake,
                         testing::Values(Mistake{1, "", "p.toml:1", "'name'"}, Mistake{2, "", "p.toml:1", "'purpose'"},
                                         Mistake{5, "start_c = 0", "p.toml:6", "temperatures.start_c"},
                                         Mistake{5, "overshoot_c = -1", "p.toml:6", "overshoot_c"},
                                         Mistake{5, "ramp_rate_kpmin = 0", "p.toml:6", "ramp_rate_kpmin"},
                                         Mistake{7, "between_runs = \"shuffle\"", "p.toml:8", "rotate_and_reverse"},
                                         Mistake{7, "dwell_s = nan", "p.toml:8", "dwell_s"},
                                         Mistake{7, "[stability]\nmin_window_s = 400", "p.toml:9", "window_s"},
                                         Mistake{7, "[stability]\nafter_turn_s = 301", "p.toml:9", "window_s"},
                                         Mistake{7, "[stability]\ntimeout_s = 600", "p.toml:9", "timeout_s"},
                                         Mistake{7, "[stability]\non_timeout = \"hope\"", "p.toml:9", "skip_plateau"},
                                         Mistake{7, "[units]\nrate_hz = 5", "p.toml:8", "temp_rate_hz"},
                                         Mistake{7, "[units]\ntemp_rate_hz = 0.1", "p.toml:1", "0.1 Hz"},
                                         Mistake{7, "[segment]\nattempts = 0", "p.toml:9", "attempts"},
                                         Mistake{7, "[end]\ntemp_c = 24.9", "p.toml:9", "25"},
                                         Mistake{7, "[power]\ncycle_at_visit = 1", "p.toml:9", "visit 1"},
                                         Mistake{7, "[power]\ncycle_at_visit = -1", "p.toml:9", "cycle_at_visit"},
                                         Mistake{7, "[power]\ncycles = 2", "p.toml:9", "cycle_at_visit"},
                                         Mistake{7, "[power]\ncycles = 0", "p.toml:9", "cycles"},
                                         Mistake{7, "turned_deg = 181", "p.toml:8", "turned_deg"},
                                         Mistake{7, "[preflight]\nposition_s = -1", "p.toml:9", "position_s"}));

TEST(Procedure, PlusAndMinusOfAnAxisMustFollowEachOther) {
  const auto p = parse_procedure(
      "name=\"n\"\npurpose=\"diagnosis\"\nkind=\"soak\"\ntemperatures.list_c=[0]\n"
      "positions.order=[\"+X\",\"+Y\",\"-X\",\"-Y\"]\n",
      "p.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().where, "p.toml:5");
  EXPECT_TRUE(names(p.error(), {"'+X'", "'-X'"}));
}

TEST(Procedure, RampAndRestHaveOnePositionAndRestOneTemperature) {
  const std::string rest =
      "name=\"n\"\npurpose=\"diagnosis\"\nkind=\"{}\"\ntemperatures.list_c={}\npositions.order={}\n";
  const auto mistake = [&](const char* kind, const char* list, const char* order) {
    const auto p = parse_procedure(fmt::format(fmt::runtime(rest), kind, list, order), "p.toml");
    return p ? std::string() : p.error().where;
  };
  EXPECT_EQ(mistake("rest", "[25]", "[\"+Z\"]"), "");
  EXPECT_EQ(mistake("ramp", "[0, 25]", "[\"+Z\"]"), "");
  EXPECT_EQ(mistake("rest", "[0, 25]", "[\"+Z\"]"), "p.toml:4");
  EXPECT_EQ(mistake("ramp", "[0, 25]", "[\"+Z\", \"-Z\"]"), "p.toml:5");
  EXPECT_EQ(mistake("soak", "[]", "[\"+Z\"]"), "p.toml:4");
  EXPECT_EQ(mistake("soak", "[0]", "[]"), "p.toml:5");
}

TEST(Procedure, AFileThatIsNotThereIsRefusedByName) {
  const auto p = read_procedure("/nowhere/p.toml");
  ASSERT_FALSE(p);
  EXPECT_EQ(p.error().where, "/nowhere/p.toml");
}

TEST(Procedure, OneThatMakesMoreThanAHundredThousandStepsIsRefusedAtItsLine) {
  // 48 set points of six positions: 48 × (3 × 6 + 2) = 960 steps a run.
  std::string set_points = "0";
  for (int i = 1; i < 48; ++i) set_points += ", " + std::to_string(i);
  const auto of_runs = [&](int runs) {
    return parse_procedure(fmt::format("name = \"n\"\npurpose = \"calibration\"\nkind = \"soak\"\nruns = {}\n"
                                       "[temperatures]\nlist_c = [{}]\n[positions]\norder = [\"+X\", \"-X\", \"+Y\", "
                                       "\"-Y\", \"+Z\", \"-Z\"]\n",
                                       runs, set_points),
                           "p.toml");
  };
  EXPECT_TRUE(of_runs(104));
  const auto refused = of_runs(105);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(refused.error().where, "p.toml:4");
  EXPECT_NE(refused.error().message.find("100800"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace soak::station
