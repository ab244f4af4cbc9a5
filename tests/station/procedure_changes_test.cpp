// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure_changes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "settings/rewrite.h"
#include "station/config/plan.h"
#include "station/config/procedure_folder.h"
#include "station/http/access_api.h"
#include "station/http/procedures_api.h"
#include "tests/db/support.h"
#include "tests/errors.h"
#include "tests/station/http_scripted_station.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Points = std::vector<double>;

const fs::path kShipped = fs::path(SOAK_TEST_FOLDER).parent_path() / "procedures";

std::string file_text(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

NewProcedure like(const std::string& from, ProcedureChanges changes) {
  return {from, "wide", std::move(changes), "2026-11-28 07:48 UTC by Eva"};
}

/// The lines of a text that are not in another one.
std::vector<std::string> lines_not_in(const std::string& text, const std::string& other) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (("\n" + other).find("\n" + line + "\n") == std::string::npos) found.push_back(line);
  }
  return found;
}

TEST(ProcedureChanges, OnlyTheChangedLinesDifferAndCommentsStay) {
  const std::string source = "# ours\n" + file_text(kShipped / "six-position-soak.toml") + "# the end\n";
  const auto text = changed_procedure(source, like("ours.toml", {Points{-40, 0, 22.5, 85}, 3, {}, {}}));
  ASSERT_TRUE(text) << text.error().message;
  const auto added = lines_not_in(*text, source);
  ASSERT_EQ(added.size(), 6u) << *text;
  EXPECT_EQ(added[0], "# Made from ours.toml, 2026-11-28 07:48 UTC by Eva: 4 set points from -40 to 85 °C, 3 runs.");
  EXPECT_EQ(added[1], "name = \"wide\"");
  EXPECT_TRUE(base::mentions(added[2], {"Like six-position-soak, but with 4 set points from -40 to 85 °C, 3 runs."}));
  EXPECT_EQ(added[4], "runs = 3");
  EXPECT_EQ(added[5], "list_c = [-40.0, 0.0, 22.5, 85.0]");
  const auto gone = lines_not_in(source, *text);
  EXPECT_EQ(
      std::ranges::count_if(gone, [](const auto& line) { return line.starts_with("st") || line.starts_with("sw"); }), 4)
      << "the grid";
  EXPECT_EQ(gone.size(), 8u) << fmt::format("{}", fmt::join(gone, "|"));
}

/// What a procedure says, but for what the test changes.
json rest_of(Procedure procedure) {
  procedure.name = procedure.description = procedure.file = "";
  procedure.set_points_c.clear();
  procedure.runs = 1;
  procedure.dwell_s = procedure.stability.minimum_soak_s = 0.0;
  procedure.cycle_at_visit = std::nullopt;
  json document = plan_document({procedure, {}, {}});
  document["stability"] = {procedure.stability.slope_kpmin, procedure.stability.window_s,
                           procedure.stability.timeout_s};
  document["overshoot_c"] = procedure.overshoot_c;
  document["rates"] = {procedure.rates_dps, procedure.rate_dwell_s};
  document["power"] = {procedure.power_off_s, procedure.cycles, procedure.preflight_position_s};
  return document;
}

TEST(ProcedureChanges, EveryShippedProcedureCanBeChangedAndAllElseOfItStays) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kShipped)) {
    if (entry.path().extension() != ".toml") continue;
    ++files;
    const std::string file = entry.path().filename();
    const std::string source = file_text(entry.path());
    const Procedure before = parse_procedure(source, file).value();
    const bool is_ramp = before.kind == ProcedureKind::ramp;
    Points points = before.kind == ProcedureKind::rest ? Points{35} : Points{-10, 10, 30, 5};
    if (before.cycle_at_visit) points.resize(static_cast<std::size_t>(*before.cycle_at_visit) + 2, 20.0);
    ProcedureChanges changes = {points, 2, 120.0, 900.0};
    if (is_ramp) changes.dwell_s = changes.minimum_soak_s = std::nullopt;
    const auto text = changed_procedure(source, like(file, changes));
    ASSERT_TRUE(text) << file << ": " << text.error().message;
    const Procedure after = parse_procedure(*text, file).value();
    EXPECT_EQ(after.name, "wide");
    EXPECT_EQ(changeable_document(after)["set_points_c"].get<Points>(), points) << file;
    EXPECT_EQ(after.reference_c, before.reference_c) << file;
    EXPECT_EQ(after.runs, 2);
    EXPECT_EQ(after.dwell_s, is_ramp ? before.dwell_s : 120.0) << file;
    EXPECT_EQ(after.stability.minimum_soak_s, is_ramp ? before.stability.minimum_soak_s : 900.0) << file;
    EXPECT_EQ(rest_of(after), rest_of(before)) << file;
    EXPECT_EQ(std::ranges::count(*text, '#'), std::ranges::count(source, '#') + 1) << file << ": comments stay";
  }
  EXPECT_GT(files, 10);
}

TEST(ProcedureChanges, WhatIsOfferedForAChangeGivesTheSameCourseAgain) {
  for (const auto& entry : fs::directory_iterator(kShipped)) {
    if (entry.path().extension() != ".toml") continue;
    const std::string source = file_text(entry.path());
    const Procedure before = parse_procedure(source, "p.toml").value();
    const auto offered = changeable_document(before)["set_points_c"].get<Points>();
    const auto text = changed_procedure(source, like("p.toml", {offered, {}, {}, {}}));
    ASSERT_TRUE(text) << entry.path() << text.error().message;
    EXPECT_EQ(parse_procedure(*text, "p.toml")->set_points_c, before.set_points_c) << entry.path();
  }
}

constexpr const char* kInline = R"(name = 'inline'; # °C
purpose = "calibration"
kind = "soak"
temperatures = {list_c = [0, 20], overshoot_c = 1.5}
positions.order = ["+X", "-X"]
positions.dwell_s = 90)";

TEST(ProcedureChanges, InlineTablesAndDottedKeysKeepAllOtherSettings) {
  std::string source = kInline;
  source.erase(source.find(';'), 1);
  const auto text = changed_procedure(source, like("p.toml", {Points{0, 40}, 2, 120.0, 700.0}));
  ASSERT_TRUE(text) << text.error().message;
  const Procedure procedure = parse_procedure(*text, "p.toml").value();
  EXPECT_EQ(procedure.set_points_c, (Points{0, 40}));
  EXPECT_EQ(procedure.overshoot_c, 1.5);
  EXPECT_EQ(procedure.positions.size(), 2u);
  EXPECT_EQ(procedure.runs, 2);
  EXPECT_EQ(procedure.dwell_s, 120.0);
  EXPECT_EQ(procedure.stability.minimum_soak_s, 700.0);
}

TEST(ProcedureChanges, AKeyIsChangedWhereverItStandsInItsLine) {
  using settings::rewritten;
  const std::string text = "# é\r\na = \"°°\" # kept\nlist = [1,\n  2] # too\n[t] # table\nx = 1\ny = 'z'";
  EXPECT_EQ(rewritten(text, "f", {{"", "a", std::string("b")}, {"t", "x", 2.5}}).value(),
            "# é\r\na = \"b\" # kept\nlist = [1,\n  2] # too\n[t] # table\nx = 2.5\ny = 'z'\n");
  EXPECT_EQ(rewritten(text, "f", {{"", "list", {}}, {"t", "y", {}}, {"t", "n", std::int64_t{3}}}).value(),
            "# é\r\na = \"°°\" # kept\n[t] # table\nn = 3\nx = 1\n");
  EXPECT_EQ(rewritten("[t]\nx = 1\n", "f", {{"", "a", 1.0}, {"u", "b", 2.0}}).value(),
            "a = 1.0\n[t]\nx = 1\n\n[u]\nb = 2.0\n");
  EXPECT_TRUE(base::is_bad_input(rewritten("a = 1", "f.toml", {{"a", "b", 1.0}}), {"f.toml", "'a'"}));
  EXPECT_TRUE(base::is_bad_input(rewritten("a = ", "f.toml", {}), {"f.toml"}));
}

/// The member at which changes are refused; empty where they are not.
std::string change_refused_at(const std::string& file, ProcedureChanges changes, const std::string& mentioned = "") {
  const auto text = changed_procedure(file_text(kShipped / file), like(file, std::move(changes)));
  if (text) return "";
  EXPECT_EQ(text.error().kind, base::ErrorKind::bad_input);
  EXPECT_TRUE(base::mentions(text.error().message, {mentioned}));
  EXPECT_EQ(text.error().message.find(".toml:"), std::string::npos) << "no place in a file that nobody sees";
  return text.error().where;
}

TEST(ProcedureChanges, ARefusalNamesTheFieldThatItFollowsFrom) {
  const std::string soak = "six-position-soak.toml";
  EXPECT_EQ(change_refused_at(soak, {Points{-20, 301}, {}, {}, {}}, "301"), "set_points_c");
  EXPECT_EQ(change_refused_at(soak, {Points{-201, 20}, {}, {}, {}}, "-201"), "set_points_c");
  EXPECT_EQ(change_refused_at(soak, {Points{}, {}, {}, {}}), "set_points_c");
  EXPECT_EQ(change_refused_at(soak, {Points(2001, 20.0), {}, {}, {}}, "2001"), "set_points_c");
  EXPECT_EQ(change_refused_at(soak, {Points{25}, {}, {}, {}}, "reference plateau"), "set_points_c");
  EXPECT_EQ(change_refused_at(soak, {{}, {}, {}, {}}), "set_points_c") << "nothing is changed";
  EXPECT_EQ(change_refused_at(soak, {{}, 0, {}, {}}), "runs");
  EXPECT_EQ(change_refused_at(soak, {{}, 3, 0.5, {}}), "dwell_s");
  EXPECT_EQ(change_refused_at(soak, {{}, 3, 60.0, 9000.0}, "timeout_s"), "minimum_soak_s");
  EXPECT_EQ(change_refused_at("static-allan.toml", {Points{20, 30}, {}, {}, {}}), "set_points_c");
  EXPECT_EQ(change_refused_at("thermal-ramp.toml", {{}, {}, 60.0, {}}), "dwell_s");
  EXPECT_EQ(change_refused_at("thermal-ramp.toml", {{}, {}, {}, 60.0}), "minimum_soak_s");
  const auto broken = changed_procedure("name = 3\n", like("b.toml", {{}, 2, {}, {}}));
  ASSERT_TRUE(base::is_bad_input(broken));
  EXPECT_EQ(broken.error().where, "from");
}

/// What nobody may make a file of, or reach one by.
const std::vector<std::string> kHostileNames = {"",
                                                ".",
                                                "..",
                                                "../x",
                                                "/etc/passwd",
                                                "a/b",
                                                "a\\b",
                                                "a.toml",
                                                "-rf",
                                                "_x",
                                                "a b",
                                                "a\nb",
                                                "a\tb",
                                                "ä",
                                                "a\xFF",
                                                "con:",
                                                "x%2fy",
                                                "a;b",
                                                "$(x)",
                                                "<b>a</b>",
                                                "\xE2\x80\xAE",
                                                std::string("a\0b", 3),
                                                std::string(61, 'a'),
                                                "a'b",
                                                "~"};

/// The interface before a data folder of its own.
class NewProcedures : public ::testing::Test {
 protected:
  base::Result<json> events() {
    return archive.in_turn([](db::Catalog& catalog) -> base::Result<json> {
      json list = json::array();
      const auto events = catalog.events().value();
      for (const auto& event : events) list.push_back({event.kind, event.subject, event.text, event.user});
      return list;
    });
  }
  base::Result<json> send(const json& changed = json::object()) {
    json body = {{"from", "verification.toml"}, {"name", "between"}, {"set_points_c", {-22.5, 37.5}}, {"user", "Eva"}};
    body.merge_patch(changed);
    return new_procedure(lab, archive, body);
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(data)) {
      const std::string name = entry.path().filename();
      if (!name.starts_with("station.db") && entry.is_regular_file()) names.push_back(name);
    }
    return names;
  }

  ScriptedStation lab;
  db::testing::TempFolder folder;
  fs::path data = folder.path();
  db::Catalog catalog = db::Catalog::open(data).value();
  RunArchive archive{data};
};

TEST_F(NewProcedures, OneIsWrittenIntoTheStationsFolderOfferedAndInTheEventLog) {
  const auto answer = send();
  ASSERT_TRUE(answer) << answer.error().where << ": " << answer.error().message;
  EXPECT_EQ((*answer)["file"], "between.toml");
  EXPECT_EQ(file_text(data / "procedures" / "between.toml"), (*answer)["text"]);
  EXPECT_TRUE(base::mentions((*answer)["text"].get<std::string>(),
                             {"# Made from verification.toml, 2", " UTC by Eva: 2 set points"}));
  EXPECT_EQ(events().value().back(),
            json({"procedure_made", "between", "from verification.toml: 2 set points from -22.5 to 37.5 °C", "Eva"}));
  const json listed = procedures_document(procedure_folders(data), "between.toml", 25.0)["procedures"].at(0);
  EXPECT_EQ(listed["text"], (*answer)["text"]);
  EXPECT_EQ(listed["changeable"]["set_points_c"], json({-22.5, 37.5}));
}

TEST_F(NewProcedures, ADraftWritesNothing) {
  const auto answer = send({{"draft", true}});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_TRUE(parse_procedure((*answer)["text"].get<std::string>(), "p"));
  EXPECT_EQ(files(), std::vector<std::string>());
  EXPECT_EQ(events().value(), json::array());
}

TEST_F(NewProcedures, NoneIsWrittenOverAndNoneHidden) {
  ASSERT_TRUE(send());
  const std::string first = file_text(data / "procedures" / "between.toml");
  fs::create_symlink(data / "nowhere", data / "procedures" / "dangling.toml");
  for (const char* name : {"between", "verification", "six-position-soak", "dangling"}) {
    const auto again = send({{"name", name}, {"set_points_c", {0, 10}}});
    ASSERT_TRUE(base::is_bad_input(again, {name})) << name;
    EXPECT_EQ(again.error().where, "name");
  }
  EXPECT_EQ(file_text(data / "procedures" / "between.toml"), first);
  EXPECT_EQ(files(), std::vector<std::string>{"between.toml"});
  EXPECT_EQ(events().value().size(), 1u);
}

TEST_F(NewProcedures, AnAttackersNamesReachNoFile) {
  std::ofstream(data / "secret.toml") << file_text(kShipped / "verification.toml");
  for (const std::string& name : kHostileNames) {
    const auto made = send({{"name", name}});
    ASSERT_TRUE(base::is_bad_input(made)) << name;
    EXPECT_EQ(made.error().where, "name") << name;
  }
  for (const char* from : {"../secret.toml", "..", "", "/etc/passwd", "procedures/../secret.toml", "verification",
                           "units/mti-300.toml", "verification.toml\n"}) {
    const auto made = send({{"from", from}});
    ASSERT_TRUE(base::is_bad_input(made)) << from;
    EXPECT_EQ(made.error().where, "from") << from;
  }
  // A name in the comment's line cannot end it and add keys.
  EXPECT_TRUE(base::is_bad_input(send({{"user", "Eva\nname = \"x\""}}), {"user"}));
  EXPECT_EQ(files(), std::vector<std::string>{"secret.toml"});
  EXPECT_EQ(events().value(), json::array());
}

TEST_F(NewProcedures, WhoeverMayStartACampaignMayMakeOne) {
  EXPECT_EQ(role_of_command("procedures/new", json::object()), Role::operating);
}

}  // namespace
}  // namespace soak::station
