// SPDX-License-Identifier: Apache-2.0
// The note without which no soakd may drive a chamber by itself: whatever is wrong with it, nothing goes on.
#include "station/lab/campaign_note.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>

namespace soak::station {
namespace {

namespace fs = std::filesystem;

class CampaignNoteTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "soak-note-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ / "soakd.campaign";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& text) const { std::ofstream(path_) << text; }

  fs::path folder_;
  fs::path path_;
};

TEST_F(CampaignNoteTest, IsReadAsItWasKept) {
  const CampaignNoteFile file(path_);
  const CampaignNote aborted{"c", false, "aborted", "aborted by \"B\n\": smoke", "B"};
  for (const CampaignNote& note : {CampaignNote{"c", true, "", "", ""}, aborted}) {
    file.keep(note);
    EXPECT_EQ(CampaignNoteFile(path_).read(), note);
  }
}

TEST_F(CampaignNoteTest, LetsNothingGoOnWhereThereIsNoneOrItCannotBeRead) {
  EXPECT_EQ(CampaignNoteFile(path_).read(), CampaignNote());
  for (const char* text : {"", "{", "[]", "true", R"({"goes_on": true})",
                           R"({"campaign": "c", "goes_on": 1, "outcome": "", "reason": "", "user": ""})"}) {
    write(text);
    EXPECT_EQ(CampaignNoteFile(path_).read(), CampaignNote()) << text;
  }
}

TEST_F(CampaignNoteTest, LetsNothingGoOnWhereANewOneCannotBeWritten) {
  const CampaignNoteFile file(path_);
  file.keep({"c", true, "", "", ""});
  // The temporary file cannot be created, as on a full disk.
  fs::create_directory(path_.string() + ".tmp" + std::to_string(::getpid()));
  file.keep({"c", false, "aborted", "", ""});
  EXPECT_EQ(file.read(), CampaignNote());
}

}  // namespace
}  // namespace soak::station
