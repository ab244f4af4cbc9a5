// SPDX-License-Identifier: Apache-2.0
// The note without which no soakd may drive a chamber by itself: whatever is wrong with it, nothing goes on.
#include "station/lab/campaign_note.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>
#include <thread>

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLongest = 60s;  // the machine may be busy

class CampaignNoteTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-note-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ / "soakd.campaign";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& text) const { std::ofstream(path_) << text; }
  CampaignNote found() const { return read_campaign_note(path_).note; }
  /// Where the keeper writes before it renames.
  fs::path temporary() const { return path_.string() + ".tmp" + std::to_string(::getpid()); }

  fs::path folder_;
  fs::path path_;
  const CampaignNote goes_on_{.campaign = "c", .goes_on = true};
};

TEST_F(CampaignNoteTest, IsReadAsItWasKept) {
  const CampaignNote aborted{"c", false, true, "aborted", "aborted by \"B\n\": smoke", "B"};
  CampaignNoteKeeper keeper(path_);
  for (const CampaignNote& note : {goes_on_, aborted}) {
    keeper.keep(note);
    ASSERT_TRUE(keeper.wait_until_kept(kLongest));
    EXPECT_EQ(found(), note);
  }
}

TEST_F(CampaignNoteTest, IsKeptThoughSoakdEndsAtOnce) {
  CampaignNoteKeeper(path_).keep(goes_on_);
  EXPECT_EQ(found(), goes_on_);
}

TEST_F(CampaignNoteTest, StaysAsItWasFoundUntilAnotherIsKept) {
  CampaignNoteKeeper(path_).keep(goes_on_);
  const double noted_utc_s = read_campaign_note(path_).noted_utc_s;
  {
    const CampaignNoteKeeper keeper(path_, 1ms);
  }
  EXPECT_EQ(read_campaign_note(path_).noted_utc_s, noted_utc_s);
}

TEST_F(CampaignNoteTest, LetsNothingGoOnWhereThereIsNoneOrItCannotBeRead) {
  EXPECT_EQ(found(), CampaignNote());
  const std::string rest = R"("outputs_off": false, "outcome": "", "reason": "", "user": "", )";
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("true"), std::string(R"({"goes_on": true})"),
        R"({"campaign": "c", "goes_on": true, )" + rest + R"("noted_utc_s": "now"})",
        R"({"campaign": "c", "goes_on": 1, )" + rest + R"("noted_utc_s": 1.0})"}) {
    write(text);
    EXPECT_EQ(found(), CampaignNote()) << text;
  }
  write(R"({"campaign": "c", "goes_on": true, )" + rest + R"("noted_utc_s": 1.0})");
  EXPECT_EQ(found(), goes_on_);
}

TEST_F(CampaignNoteTest, IsTakenAwayWhereANewOneCannotBeWrittenAndTriedAgain) {
  CampaignNoteKeeper keeper(path_);
  keeper.keep(goes_on_);
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  fs::create_directory(temporary());  // the temporary file cannot be created, as on a full disk
  const CampaignNote aborted{.campaign = "c", .outcome = "aborted"};
  keeper.keep(aborted);
  const auto deadline = std::chrono::steady_clock::now() + kLongest;
  while (keeper.trouble().empty() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(1ms);
  EXPECT_NE(keeper.trouble(), "");
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_FALSE(keeper.wait_until_kept(0ms));
  fs::remove(temporary());
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  EXPECT_EQ(found(), aborted);
  EXPECT_EQ(keeper.trouble(), "");
}

TEST_F(CampaignNoteTest, OnceWithdrawnLetsNothingGoOnUntilSomebodyAllowsIt) {
  CampaignNoteKeeper keeper(path_);
  keeper.keep(goes_on_);
  keeper.withdraw();
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  EXPECT_EQ(found(), CampaignNote{.campaign = "c"});
  CampaignNote next = goes_on_;
  next.reason = "an engine that does not know of it yet";
  keeper.keep(next);
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  EXPECT_FALSE(found().goes_on);
  keeper.allow();
  keeper.keep(next);
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  EXPECT_EQ(found(), next);
}

TEST_F(CampaignNoteTest, OfAPredecessorIsWithdrawnAsWell) {
  CampaignNoteKeeper(path_).keep(goes_on_);
  CampaignNoteKeeper keeper(path_);
  EXPECT_EQ(keeper.found().note, goes_on_);
  keeper.withdraw(true);
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  EXPECT_EQ(found(), (CampaignNote{.campaign = "c", .outputs_off = true}));
}

TEST_F(CampaignNoteTest, SaysWhenItWasTrueAtLast) {
  CampaignNoteKeeper keeper(path_, 1ms);
  keeper.keep(goes_on_);
  ASSERT_TRUE(keeper.wait_until_kept(kLongest));
  const double first_utc_s = read_campaign_note(path_).noted_utc_s;
  const auto deadline = std::chrono::steady_clock::now() + kLongest;
  while (read_campaign_note(path_).noted_utc_s <= first_utc_s && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_GT(read_campaign_note(path_).noted_utc_s, first_utc_s);
  EXPECT_EQ(found(), goes_on_);
}

TEST(CampaignBreak, IsRecentForTwelveHoursAndNotInTheFuture) {
  constexpr double kNow_utc_s = 1.8e9;
  EXPECT_TRUE(is_recent_break(kNow_utc_s, kNow_utc_s));
  EXPECT_TRUE(is_recent_break(kNow_utc_s - 11.9 * 3600.0, kNow_utc_s));
  EXPECT_FALSE(is_recent_break(kNow_utc_s - 12.1 * 3600.0, kNow_utc_s));
  EXPECT_FALSE(is_recent_break(kNow_utc_s + 3600.0, kNow_utc_s));
  EXPECT_FALSE(is_recent_break(0.0, kNow_utc_s));
}

}  // namespace
}  // namespace soak::station
