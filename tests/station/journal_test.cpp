// SPDX-License-Identifier: Apache-2.0
// The lock is a real one: of another connection to the catalog, as another program has it.
#include "station/lab/journal.h"

#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <filesystem>

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kSoon{20'000};  // generous: the machine may be busy, and a try takes up to the busy time-out

class JournalTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-journal-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    catalog_.emplace(*db::Catalog::open(folder_));
    ASSERT_TRUE(catalog_->begin_campaign({.name = "c", .procedure = "p", .document = "{}"}));
    before_ = catalog_->events()->size();
  }
  void TearDown() override {
    catalog_.reset();
    fs::remove_all(folder_);
  }

  std::unique_ptr<Journal> open(std::size_t most_events = Journal::kMostEvents) {
    return *Journal::open(folder_, [this] { ++told_; }, most_events);
  }
  /// Takes the lock that writers need; readers go on.
  std::unique_ptr<SQLite::Database> lock() const {
    auto other = std::make_unique<SQLite::Database>((folder_ / "station.db").string(), SQLite::OPEN_READWRITE);
    other->exec("BEGIN IMMEDIATE");
    return other;
  }
  /// Texts of the events since the campaign began.
  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    const auto events = catalog_->events();
    for (std::size_t i = before_; i < events->size(); ++i) texts.push_back((*events)[i].text);
    return texts;
  }
  static db::EventRow event(const std::string& text) { return {1.0, "kind", "subject", text}; }
  static db::StepRow step(std::int32_t index) {
    db::StepRow row;
    row.campaign = "c";
    row.index = index;
    row.outcome = "done";
    return row;
  }

  fs::path folder_;
  std::optional<db::Catalog> catalog_;
  std::size_t before_ = 0;
  std::atomic<int> told_ = 0;
};

TEST_F(JournalTest, WritesWhatItIsGivenAndSaysWhen) {
  const auto journal = open();
  journal->add(event("one"));
  const auto ticket = journal->add(step(0));
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->written(ticket), Journal::Written::yes);
  EXPECT_EQ(texts(), std::vector<std::string>{"one"});
  EXPECT_EQ(catalog_->completed_steps("c")->size(), 1U);
  EXPECT_EQ(journal->standing().queued, 0U);
  journal->end();
  EXPECT_GE(told_, 1) << "after each transaction";
}

TEST_F(JournalTest, NeverMakesItsCallerWaitForALockAndKeepsTheOrder) {
  const auto journal = open();
  auto other = lock();
  const auto begun = steady_clock::now();
  journal->add(event("one"));
  const auto first = journal->add(step(0));
  journal->add(event("two"));
  const auto second = journal->add(step(1));
  journal->add(Journal::State{"c", "paused", "three"});
  journal->add(event("four"));
  EXPECT_LT(steady_clock::now() - begun, std::chrono::seconds(1));
  EXPECT_FALSE(journal->wait_until_written(milliseconds(100)));
  EXPECT_EQ(journal->written(first), Journal::Written::not_yet);
  EXPECT_EQ(journal->standing().queued, 6U);
  EXPECT_GE(journal->standing().behind_s, 0.1);
  EXPECT_EQ(texts(), std::vector<std::string>{});
  other.reset();
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->written(first), Journal::Written::yes);
  EXPECT_EQ(journal->written(second), Journal::Written::yes);
  EXPECT_EQ(texts(), (std::vector<std::string>{"one", "two", "three", "four"}));
  EXPECT_EQ((*catalog_->campaign("c"))->state, "paused");
}

TEST_F(JournalTest, KeepsSoManyEventsAndEveryStep) {
  const auto journal = open(3);
  auto other = lock();
  for (const char* text : {"one", "two", "three", "four", "five"}) journal->add(event(text));
  const auto ticket = journal->add(step(7));
  EXPECT_EQ(journal->standing().discarded, 2U);
  EXPECT_EQ(journal->standing().queued, 4U);
  other.reset();
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->written(ticket), Journal::Written::yes);
  journal->add(event("six"));
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  const auto all = texts();
  ASSERT_EQ(all.size(), 5U) << "the gap is told of in its place";
  EXPECT_EQ(all[2], "three");
  EXPECT_NE(all[3].find("2 "), std::string::npos);
  EXPECT_EQ(all[4], "six");
}

TEST_F(JournalTest, TellsOfAnEntryThatTheCatalogRefusesAndGoesOn) {
  const auto journal = open();
  journal->add(step(0));
  const auto again = journal->add(step(0));
  journal->add(event("after"));
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->written(again), Journal::Written::refused);
  EXPECT_FALSE(journal->refusal().empty());
  EXPECT_EQ(texts(), std::vector<std::string>{"after"});
}

TEST_F(JournalTest, WritesWhatHasWaitedInOneTransactionAndLeavesOutWhatIsRefused) {
  const auto journal = open();
  journal->add(step(0));
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  auto other = lock();
  told_ = 0;
  std::vector<std::string> expected;
  Journal::Ticket refused = 0;
  for (int i = 0; i < 200; ++i) {
    if (i == 100) refused = journal->add(step(0));
    expected.push_back(std::to_string(i));
    journal->add(event(expected.back()));
  }
  const auto last = journal->add(step(1));
  other.reset();
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(texts(), expected);
  EXPECT_EQ(journal->written(refused), Journal::Written::refused);
  EXPECT_EQ(journal->written(last), Journal::Written::yes);
  journal->end();
  // The first one may have been tried by itself before the others came; then those before the refused one, that one,
  // and the rest.
  EXPECT_LE(told_, 4);
}

TEST_F(JournalTest, SaysWhyItCannotWriteAfterTheBusyTimeOut) {
  const auto journal = open();
  auto other = lock();
  journal->add(event("one"));
  for (const auto end = steady_clock::now() + 2 * kSoon; journal->standing().trouble.empty();) {
    ASSERT_LT(steady_clock::now(), end);
    (void)journal->wait_until_written(milliseconds(50));
  }
  other.reset();
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->standing().trouble, "");
  EXPECT_EQ(texts(), std::vector<std::string>{"one"});
}

TEST_F(JournalTest, NeverTakesARefusedStepForWrittenWhateverIsRefusedAfterIt) {
  const auto journal = open();
  journal->add(step(0));
  const auto first = journal->add(step(0));
  const auto second = journal->add(step(0));
  journal->add(Journal::State{"unknown", "running", ""});
  ASSERT_TRUE(journal->wait_until_written(kSoon));
  EXPECT_EQ(journal->written(first), Journal::Written::refused);
  EXPECT_EQ(journal->written(second), Journal::Written::refused);
}

}  // namespace
}  // namespace soak::station
