// SPDX-License-Identifier: Apache-2.0
// What asks for a part of the catalog finds it by an index: the plans of all statements that such questions run, read
// from SQLite. A catalog of 10,000 units and 200,000 runs is otherwise read from end to end at each of them.
#include <sqlite3.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "db/catalog/run_record.h"
#include "tests/db/sample_catalog.h"
#include "tests/db/sample_records.h"

namespace soak::db {
namespace {

using testing::kRunId;
using testing::TempFolder;

/// An index of the campaigns that are open, of which there is one at most.
constexpr std::string_view kOpenCampaigns = "SCAN journal USING INDEX journal_open";

/// Each SQL text that the connections opened in its life run.
class Statements {
 public:
  Statements() {
    texts().clear();
    sqlite3_auto_extension(entry_point());
  }
  Statements(const Statements&) = delete;
  Statements& operator=(const Statements&) = delete;
  ~Statements() { sqlite3_cancel_auto_extension(entry_point()); }

  static std::set<std::string>& texts() {
    static std::set<std::string> run;
    return run;
  }

 private:
  static int listen(sqlite3* database, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    return sqlite3_trace_v2(database, SQLITE_TRACE_STMT, &note, nullptr);
  }
  static int note(unsigned /*kind*/, void* /*context*/, void* statement, void* text) {
    // Statements of triggers come as comments.
    if (std::string_view(static_cast<const char*>(text)).substr(0, 2) != "--") {
      texts().insert(sqlite3_sql(static_cast<sqlite3_stmt*>(statement)));
    }
    return 0;
  }
  static void (*entry_point())() { return reinterpret_cast<void (*)()>(&listen); }
};

/// The steps of the plans of `statements`, each with its statement.
std::vector<std::string> steps_of(const std::filesystem::path& file, const std::set<std::string>& statements) {
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
  std::vector<std::string> found;
  for (const std::string& sql : statements) {
    if (sql.starts_with("PRAGMA") || sql.starts_with("BEGIN") || sql == "COMMIT" || sql == "ROLLBACK") continue;
    sqlite3_stmt* plan = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, ("EXPLAIN QUERY PLAN " + sql).c_str(), -1, &plan, nullptr), SQLITE_OK)
        << sql << ": " << sqlite3_errmsg(database);
    while (sqlite3_step(plan) == SQLITE_ROW) {
      const std::string step = reinterpret_cast<const char*>(sqlite3_column_text(plan, 3));
      found.push_back(step + " in: " + sql);
    }
    sqlite3_finalize(plan);
  }
  sqlite3_close(database);
  return found;
}

/// Those steps that read a whole table or index.
std::vector<std::string> whole_tables_read(const std::vector<std::string>& steps) {
  std::vector<std::string> found;
  std::ranges::copy_if(steps, std::back_inserter(found), [](const std::string& step) {
    return step.starts_with("SCAN ") && !step.starts_with(kOpenCampaigns);
  });
  return found;
}

class QueryPlans : public ::testing::Test {
 protected:
  void SetUp() override {
    auto catalog = Catalog::open(folder_.path()).value();
    testing::fill(catalog);
    ASSERT_TRUE(catalog.add_reference(testing::probe_row()));
  }

  std::vector<std::string> steps_of_question(const std::function<bool(const Catalog&)>& question) {
    const Statements statements;
    const auto catalog = Catalog::open(folder_.path()).value();
    Statements::texts().clear();
    EXPECT_TRUE(question(catalog));
    EXPECT_FALSE(Statements::texts().empty());
    return steps_of(folder_ / "station.db", Statements::texts());
  }

  TempFolder folder_;
};

TEST_F(QueryPlans, AReadOfAWholeTableIsSeen) {
  const auto found =
      whole_tables_read(steps_of_question([](const Catalog& catalog) { return catalog.units().has_value(); }));
  ASSERT_EQ(found.size(), 1);
  EXPECT_TRUE(found[0].starts_with("SCAN unit")) << found[0];
}

TEST_F(QueryPlans, WhatAsksForAPartUsesAnIndex) {
  const std::pair<const char*, std::function<bool(const Catalog&)>> questions[] = {
      {"unit", [](const Catalog& c) { return c.unit("SN1").has_value(); }},
      {"runs of a unit", [](const Catalog& c) { return c.runs({"SN1", {}, {}}).has_value(); }},
      {"runs of a campaign", [](const Catalog& c) { return c.runs({{}, "c1", {}}).has_value(); }},
      {"runs of a unit in a campaign", [](const Catalog& c) { return c.runs({"SN1", "c1", {}}).has_value(); }},
      {"run of a unit by its label", [](const Catalog& c) { return c.runs({"SN1", {}, "r1"}).has_value(); }},
      {"run of a unit by its id", [](const Catalog& c) { return c.runs({"SN1", {}, kRunId}).has_value(); }},
      {"run record", [](const Catalog& c) { return c.run_record(kRunId, "SN1").has_value(); }},
      {"voids", [](const Catalog& c) { return c.voids(kRunId).has_value(); }},
      {"campaign", [](const Catalog& c) { return c.campaign("c1").has_value(); }},
      {"open campaign", [](const Catalog& c) { return c.open_campaign().has_value(); }},
      {"steps", [](const Catalog& c) { return c.completed_steps("c1").has_value(); }},
      {"models of a unit", [](const Catalog& c) { return c.models("SN1").has_value(); }},
      {"model", [](const Catalog& c) { return c.model("SN1").has_value(); }},
      {"model by version", [](const Catalog& c) { return c.model("SN1", 1).has_value(); }},
      {"where a model came from", [](const Catalog& c) { return c.model_origin("SN1", 1).has_value(); }},
      {"history of a model", [](const Catalog& c) { return c.model_history("SN1", 1).has_value(); }},
      {"verifications", [](const Catalog& c) { return c.verifications("SN1", 1).has_value(); }},
      {"gap reports", [](const Catalog& c) { return c.gap_reports("SN1").has_value(); }},
      {"references of a campaign", [](const Catalog& c) { return c.campaign_references("c1").has_value(); }},
  };
  for (const auto& [name, question] : questions) {
    for (const std::string& step : whole_tables_read(steps_of_question(question)))
      ADD_FAILURE() << name << ": " << step;
  }
}

TEST_F(QueryPlans, TheEventLogIsReadFromItsEndBackWithoutSorting) {
  const auto steps =
      steps_of_question([](const Catalog& c) { return c.find_events({.subject = "SN1", .most = 5}).has_value(); });
  ASSERT_EQ(steps.size(), 1);
  EXPECT_TRUE(steps[0].starts_with("SCAN event in:")) << steps[0];
  const auto of_several = steps_of_question([](const Catalog& c) {
    return c.find_events({.most = 5, .subjects = {"SN1", kRunId}, .without_kinds = {"step"}}).has_value();
  });
  ASSERT_EQ(of_several.size(), 1);
  EXPECT_TRUE(of_several[0].starts_with("SCAN event in:")) << of_several[0];
}

TEST_F(QueryPlans, TheSegmentsOfARunAreFoundByItOnceTheSealsAreChecked) {
  const Statements statements;
  const auto catalog = Catalog::open(folder_.path()).value();
  ASSERT_TRUE(catalog.segments(kRunId, "SN1", true));  // checks the seals, which are of whole tables
  Statements::texts().clear();
  ASSERT_TRUE(catalog.segments(kRunId, "SN1", true));
  ASSERT_TRUE(catalog.recorded_segments(kRunId, "SN1"));
  for (const std::string& step : whole_tables_read(steps_of(folder_ / "station.db", Statements::texts())))
    ADD_FAILURE() << step;
}

}  // namespace
}  // namespace soak::db
