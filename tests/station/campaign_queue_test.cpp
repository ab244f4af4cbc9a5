// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_queue.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/db/support.h"

namespace soak::station {
namespace {

QueuedCampaign queued(const std::string& name) {
  return {{"text of " + name + "\n[x]", name + ".toml", name, {{"1", "SN1"}, {"2", "SN2"}}, "Eva \u00c4"},
          "procedure of " + name,
          3600.5,
          1790000000.25};
}

std::vector<std::string> names_in(const CampaignQueue& queue) {
  std::vector<std::string> names;
  for (const auto& campaign : queue.document()) names.push_back(campaign.at("name"));
  return names;
}

class CampaignQueueTest : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_.path() / "soakd.queue"; }
  db::testing::TempFolder folder_;
};

TEST_F(CampaignQueueTest, KeepsWhatWasQueuedInItsOrderForTheNextSoakd) {
  CampaignQueue queue(path());
  for (const char* name : {"c", "a", "b"}) ASSERT_TRUE(queue.add(queued(name)));
  ASSERT_TRUE(queue.remove("a"));
  const CampaignQueue next(path());
  EXPECT_EQ(names_in(next), (std::vector<std::string>{"c", "b"}));
  const QueuedCampaign first = next.front().value();
  EXPECT_EQ(first.request.procedure_text, "text of c\n[x]");
  EXPECT_EQ(first.request.procedure_file, "c.toml");
  EXPECT_EQ(first.request.units, (std::map<std::string, std::string>{{"1", "SN1"}, {"2", "SN2"}}));
  EXPECT_EQ(first.request.user, "Eva \u00c4");
  EXPECT_EQ(first.procedure, "procedure of c");
  EXPECT_EQ(first.estimate_s, 3600.5);
  EXPECT_EQ(first.queued_utc_s, 1790000000.25);
  EXPECT_TRUE(next.trouble().empty());
}

TEST_F(CampaignQueueTest, RefusesANameTwiceAndOneThatItDoesNotHold) {
  CampaignQueue queue(path());
  ASSERT_TRUE(queue.add(queued("a")));
  EXPECT_EQ(queue.add(queued("a")).error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(queue.remove("b").error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(names_in(queue), std::vector<std::string>{"a"});
}

TEST_F(CampaignQueueTest, HoldsNoMoreThanItsLimit) {
  CampaignQueue queue(path());
  for (std::size_t i = 0; i < CampaignQueue::kMost; ++i) ASSERT_TRUE(queue.add(queued(std::to_string(i))));
  EXPECT_EQ(queue.add(queued("one more")).error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(queue.size(), CampaignQueue::kMost);
  EXPECT_EQ(queue.estimate_s(), 3600.5 * static_cast<double>(CampaignQueue::kMost));
}

TEST_F(CampaignQueueTest, NothingChangesWhereTheFileCannotBeWritten) {
  std::filesystem::create_directory(folder_.path() / "gone");
  CampaignQueue queue(folder_.path() / "gone" / "soakd.queue");
  ASSERT_TRUE(queue.add(queued("a")));
  std::filesystem::remove_all(folder_.path() / "gone");
  EXPECT_EQ(queue.add(queued("b")).error().kind, base::ErrorKind::internal);
  EXPECT_EQ(queue.remove("a").error().kind, base::ErrorKind::internal);
  EXPECT_EQ(names_in(queue), std::vector<std::string>{"a"});
  EXPECT_EQ(queue.take_out("a").error().kind, base::ErrorKind::internal);
  EXPECT_TRUE(queue.empty()) << "it has begun, whatever the file says";
}

TEST_F(CampaignQueueTest, AFileThatIsNoQueueIsMovedAside) {
  for (const char* text : {"", "[]", "{}", R"({"campaigns": 3})", R"({"campaigns": null})", R"({"campaigns": {}})",
                           R"({"campaigns": null})", R"({"campaigns": {}})", R"({"campaigns": [{"campaign": "a"}]})",
                           R"({"campaigns": [{"campaign": 1}]})", "\xff\xfe"}) {
    std::ofstream(path()) << text;
    CampaignQueue queue(path());
    EXPECT_TRUE(queue.empty()) << text;
    EXPECT_FALSE(queue.trouble().empty()) << text;
    EXPECT_FALSE(std::filesystem::exists(path())) << text;
    EXPECT_TRUE(std::filesystem::remove(path().string() + ".damaged")) << text;
    ASSERT_TRUE(queue.add(queued("b"))) << text;
    std::filesystem::remove(path());
  }
}

}  // namespace
}  // namespace soak::station
