// SPDX-License-Identifier: Apache-2.0
// The journal of campaigns in the catalog.
#include <array>
#include <csignal>

#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::TempFolder;

class JournalTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(catalog_) << catalog_.error().message; }

  TempFolder folder_;
  base::Result<Catalog> catalog_ = Catalog::open(folder_.path());
};

bool is_bad_input(const base::Status& status) {
  return !status && status.error().kind == base::ErrorKind::bad_input && !status.error().message.empty();
}

CampaignRow campaign(std::string name) {
  CampaignRow row;
  row.name = std::move(name);
  row.procedure = "soak";
  row.document = R"({"plan": {"steps": ["über", 1.5]}})";
  row.created_utc_s = 1700000000.125;
  return row;
}

StepRow step(std::int32_t index, std::int32_t attempt = 0) {
  return {"c1", index, attempt, 100.0 + index, 100.5 + index, "done", "all well", "run " + std::to_string(index)};
}

TEST_F(JournalTest, GivesBackACampaignAndItsSteps) {
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c1")));
  for (const auto& entered : {step(0), step(2), step(1), step(2, 1)}) ASSERT_TRUE(catalog_->complete_step(entered));
  const auto reopened = Catalog::open(folder_.path());
  const auto row = reopened->campaign("c1");
  ASSERT_TRUE(row && *row);
  EXPECT_EQ((*row)->procedure, "soak");
  EXPECT_EQ((*row)->document, campaign("c1").document);
  EXPECT_EQ((*row)->state, "running");
  EXPECT_EQ((*row)->created_utc_s, 1700000000.125);
  const auto steps = reopened->completed_steps("c1");
  ASSERT_EQ(steps->size(), 4U);
  EXPECT_EQ((*steps)[2].index, 1);
  EXPECT_EQ((*steps)[3].index, 2);
  EXPECT_EQ((*steps)[3].attempt, 1);
  EXPECT_EQ((*steps)[3].started_utc_s, 102.0);
  EXPECT_EQ((*steps)[3].ended_utc_s, 102.5);
  EXPECT_EQ((*steps)[3].outcome, "done");
  EXPECT_EQ((*steps)[3].text, "all well");
  EXPECT_EQ((*steps)[3].run_id, "run 2");
  EXPECT_TRUE(reopened->completed_steps("c9")->empty());
  EXPECT_FALSE(*reopened->campaign("c9"));
  EXPECT_EQ(*reopened->campaigns(), std::vector<std::string>{"c1"});
  EXPECT_TRUE(reopened->verify());
}

TEST_F(JournalTest, LetsOneCampaignAtATimeBeOpen) {
  EXPECT_FALSE(*catalog_->open_campaign());
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c1")));
  for (const char* state : {"running", "paused"}) {
    ASSERT_TRUE(catalog_->set_campaign_state("c1", state, ""));
    EXPECT_EQ((*catalog_->open_campaign())->name, "c1");
    EXPECT_TRUE(is_bad_input(catalog_->begin_campaign(campaign("c2"))));
    EXPECT_EQ(catalog_->campaigns()->size(), 1U);
  }
  ASSERT_TRUE(catalog_->set_campaign_state("c1", "interrupted", "power failed"));
  EXPECT_FALSE(*catalog_->open_campaign());
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c2")));
  EXPECT_TRUE(is_bad_input(catalog_->set_campaign_state("c1", "running", "")));
  ASSERT_TRUE(catalog_->set_campaign_state("c2", "finished", ""));
  EXPECT_TRUE(catalog_->set_campaign_state("c1", "running", ""));
}

TEST_F(JournalTest, TheLastCampaignIsTheOneThatWasBegunLastWhateverItsState) {
  EXPECT_FALSE(*catalog_->last_campaign());
  ASSERT_TRUE(catalog_->ensure_campaign("c0", "soak"));
  EXPECT_FALSE(*catalog_->last_campaign()) << "it has no journal";
  // Their names do not stand in the order of time.
  double begun_utc_s = 1700000000.0;
  for (const char* name : {"c5", "c9", "c1"}) {
    auto begun = campaign(name);
    begun.created_utc_s = begun_utc_s += 60.0;
    ASSERT_TRUE(catalog_->begin_campaign(begun));
    for (const char* state : {"paused", "interrupted", "running", "finished"}) {
      ASSERT_TRUE(catalog_->set_campaign_state(name, state, "why"));
      const auto last = catalog_->last_campaign();
      ASSERT_TRUE(last && *last);
      EXPECT_EQ((*last)->name, name);
      EXPECT_EQ((*last)->state, state);
      EXPECT_EQ((*last)->created_utc_s, begun_utc_s);
    }
  }
  ASSERT_TRUE(catalog_->set_campaign_state("c5", "aborted", ""));
  EXPECT_EQ((*catalog_->last_campaign())->name, "c1") << "a change of an older one does not make it newer";
}

TEST_F(JournalTest, RefusesNamesThatAreTaken) {
  testing::fill(*catalog_);
  EXPECT_TRUE(is_bad_input(catalog_->begin_campaign(campaign("c1")))) << "it has runs";
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c2")));
  ASSERT_TRUE(catalog_->set_campaign_state("c2", "failed", "chamber silent"));
  EXPECT_TRUE(is_bad_input(catalog_->begin_campaign(campaign("c2")))) << "it has a journal";
  EXPECT_TRUE(is_bad_input(catalog_->begin_campaign(campaign(""))));
  ASSERT_TRUE(catalog_->ensure_campaign("c3", "soak"));
  EXPECT_TRUE(catalog_->begin_campaign(campaign("c3"))) << "it has neither";
}

TEST_F(JournalTest, RefusesWhatHasNoMeaning) {
  auto odd = campaign("c1");
  odd.state = "walking";
  EXPECT_TRUE(is_bad_input(catalog_->begin_campaign(odd)));
  EXPECT_TRUE(is_bad_input(catalog_->complete_step(step(0)))) << "no journal";
  EXPECT_TRUE(is_bad_input(catalog_->set_campaign_state("c1", "paused", "")));
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c1")));
  EXPECT_TRUE(is_bad_input(catalog_->set_campaign_state("c1", "", "")));
  ASSERT_TRUE(catalog_->complete_step(step(0)));
  EXPECT_TRUE(is_bad_input(catalog_->complete_step(step(0)))) << "twice";
  EXPECT_TRUE(is_bad_input(catalog_->complete_step(step(-1))));
  EXPECT_EQ(catalog_->completed_steps("c1")->size(), 1U);
}

TEST_F(JournalTest, LogsEveryChangeOfState) {
  ASSERT_TRUE(catalog_->begin_campaign(campaign("c1")));
  ASSERT_TRUE(catalog_->set_campaign_state("c1", "aborted", "by ann"));
  EXPECT_EQ((*catalog_->campaign("c1"))->reason, "by ann");
  EXPECT_GT((*catalog_->campaign("c1"))->updated_utc_s, 1700000000.125);
  const auto events = catalog_->events();
  ASSERT_EQ(events->size(), 2U);
  EXPECT_EQ((*events)[0].kind, "campaign_begun");
  EXPECT_EQ((*events)[1].kind, "campaign_aborted");
  EXPECT_EQ((*events)[1].subject, "c1");
  EXPECT_EQ((*events)[1].text, "by ann");
}

/// Enters steps without end and reports each one to `report` once it is entered.
int journal_for_ever(const std::filesystem::path& folder, int report) {
  auto catalog = Catalog::open(folder);
  if (!catalog || !catalog->begin_campaign(campaign("c1"))) return 1;
  for (std::int32_t index = 0;; ++index) {
    if (!catalog->complete_step(step(index))) return 2;
    if (::write(report, &index, sizeof index) != sizeof index) return 3;
  }
}

TEST(JournalProcess, LosesNoEnteredStepWhenTheProcessIsKilled) {
  base::Random random(5);
  for (int kill = 0; kill < 6; ++kill) {
    const TempFolder folder;
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = testing::in_child([&] { return journal_for_ever(folder.path(), pipe[1]); });
    ::close(pipe[1]);
    const auto wanted = 1 + random.next() % 30;
    std::int32_t last = -1;
    for (std::uint64_t i = 0; i < wanted; ++i) ASSERT_EQ(::read(pipe[0], &last, sizeof last), sizeof last);
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    EXPECT_EQ(testing::status_of(child), -SIGKILL);
    for (std::int32_t later = 0; ::read(pipe[0], &later, sizeof later) == sizeof later;) last = later;
    ::close(pipe[0]);
    const auto catalog = Catalog::open(folder.path());
    ASSERT_TRUE(catalog) << catalog.error().message;
    const auto steps = catalog->completed_steps("c1");
    ASSERT_TRUE(steps);
    // The last one may have been entered without having been reported.
    ASSERT_GE(steps->size(), static_cast<std::size_t>(last) + 1);
    ASSERT_LE(steps->size(), static_cast<std::size_t>(last) + 2);
    for (std::size_t i = 0; i < steps->size(); ++i) EXPECT_EQ((*steps)[i].index, static_cast<std::int32_t>(i));
    EXPECT_EQ((*catalog->open_campaign())->name, "c1");
    EXPECT_TRUE(catalog->verify());
  }
}

}  // namespace
}  // namespace soak::db
