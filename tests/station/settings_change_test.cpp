// SPDX-License-Identifier: Apache-2.0
#include "station/setup/settings_change.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "settings/reader.h"
#include "settings/sections.h"
#include "station/config/unit_type_file.h"
#include "station/setup/setup_answers.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

/// As somebody has written it by hand: comments, keys that no form asks for, lists over several lines.
std::string written_by_hand() {
  return "# Station of the cellar.\n"
         "listen = \"127.0.0.1:8090\"\n"
         "\n"
         "[chamber]  # bought 2019\n"
         "map = \"" +
         (shipped_procedures() / "chambers/watlow-f4t.toml").string() +
         "\"\n"
         "host = \"10.0.0.7\"   # on the label\n"
         "port = 502 # µ-controller\n"
         "\n"
         "# Where it stands.\n"
         "[site]\n"
         "latitude_deg = 48.10\n"
         "azimuth_deg = 12   # measured\n"
         "\n"
         "[alarms.mail]\n"
         "host = \"smtp.lab.example\"\n"
         "from = \"soak@lab.example\"\n"
         "to = [\n"
         "  \"eva@lab.example\",  # first\n"
         "  \"otto@lab.example\",\n"
         "]\n"
         "user = \"soak\"\n"
         "password_file = \"old.password\"\n"
         "\n"
         "[[slot]]\n"
         "name = \"A\"\n"
         "axes = [\"+Y\", \"-X\", \"+Z\"]\n"
         "host = \"10.0.0.9\"\n"
         "port = 4001\n"
         "unit_type = \"mti-300\"\n"
         "# the second one leans\n"
         "[[slot]]\n"
         "name = \"B\"\n"
         "host = \"10.0.0.9\"\n"
         "port = 4002\n"
         "unit_type = \"mti-300\"\n"
         "\n"
         "[clock]\n"
         "rate = 1\n";
}

class SettingsChange : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / "settings_change";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("old.password", "hunter2\n");
    write("station.toml", written_by_hand());
    file_ = folder_ / "station.toml";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    ::chmod((folder_ / name).c_str(), 0600);
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    return settings::read_text((folder_ / name).string()).value_or("");
  }
  [[nodiscard]] SetupForm answers(const std::string& text = written_by_hand()) const {
    const auto form = answers_in(text, file_);
    EXPECT_TRUE(form) << form.error().message;
    return form.value_or(SetupForm());
  }
  /// What becomes of the text with these answers in it.
  [[nodiscard]] SettingsDraft draft(SetupForm form, const std::string& text = written_by_hand()) const {
    const SetupForm before = answers(text);
    const auto mistakes = keep_secrets(form, before, folder_);
    EXPECT_TRUE(mistakes.empty()) << mistakes[0].message;
    return draft_settings(text, file_, before, form);
  }
  /// The answers of the page, which never has a secret that is kept.
  [[nodiscard]] SetupForm page() const {
    SetupForm form = answers();
    if (form.mail) form.mail->password_file.clear();
    return form;
  }

  fs::path folder_;
  fs::path file_;
};

std::string with(std::string text, const std::string& old, const std::string& now) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), now);
}

TEST_F(SettingsChange, LeavesEveryByteWhereNothingIsChanged) {
  const SettingsDraft same = draft(page());
  ASSERT_TRUE(same.mistakes.empty()) << same.mistakes[0].message;
  EXPECT_EQ(same.toml, written_by_hand());
  EXPECT_EQ(same.differences, "");
  EXPECT_TRUE(same.new_secrets.empty());
}

TEST_F(SettingsChange, ChangesOneValueAndNoByteBesideIt) {
  SetupForm form = page();
  form.chamber.address.port = 503;
  form.slots[1].address.port = 4009;
  const SettingsDraft changed = draft(form);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_EQ(changed.toml, with(with(written_by_hand(), "port = 502", "port = 503"), "port = 4002", "port = 4009"));
  EXPECT_EQ(changed.differences,
            "  [chamber]\n- port = 502\n+ port = 503\n\n  [[slot]]  # 2\n- port = 4002\n+ port = 4009\n");
  EXPECT_EQ(changed.summary, "chamber: port; slot 2: port");
}

TEST_F(SettingsChange, PutsKeysAndSectionsInAndTakesThemOutAgainToTheByte) {
  SetupForm form = page();
  form.site->height_m = 520.0;
  form.room = EnteredRoom{.temp_c = 22.5, .dew_point_c = {}};
  form.slots.push_back({.name = "C", .address = {.device = "/dev/ttyUSB3", .baud = 921600}});
  const SettingsDraft changed = draft(form);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_NE(changed.toml.find("azimuth_deg = 12   # measured\nheight_m = 520\n"), std::string::npos) << changed.toml;
  EXPECT_NE(changed.toml.find("\n[room]\ntemp_c = 22.5\n"), std::string::npos);
  EXPECT_LT(changed.toml.find("name = \"C\""), changed.toml.find("[clock]"));
  EXPECT_NE(changed.toml.find("  \"eva@lab.example\",  # first\n"), std::string::npos);
  const SettingsDraft back = draft(page(), changed.toml);
  ASSERT_TRUE(back.mistakes.empty()) << back.mistakes[0].message;
  EXPECT_EQ(back.toml, written_by_hand());
}

TEST_F(SettingsChange, TakesAListOverSeveralLinesForOneValue) {
  SetupForm form = page();
  form.mail->to = {"eva@lab.example"};
  const SettingsDraft changed = draft(form);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_NE(changed.toml.find("to = [\"eva@lab.example\"]\nuser = \"soak\"\n"), std::string::npos) << changed.toml;
}

TEST_F(SettingsChange, KeepsOfASectionWhatTheFormDoesNotKnow) {
  SetupForm form = page();
  form.site.reset();
  const SettingsDraft changed = draft(form);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_EQ(changed.toml, with(written_by_hand(), "latitude_deg = 48.10\n", ""));
}

TEST_F(SettingsChange, RefusesToDropASlotOfWhichItDoesNotKnowAll) {
  const std::string text = with(written_by_hand(), "port = 4002\n", "port = 4002\naxes = [\"+Y\", \"-X\", \"+Z\"]\n");
  SetupForm form = page();
  form.slots.pop_back();
  const SettingsDraft changed = draft(form, text);
  ASSERT_EQ(changed.mistakes.size(), 1U);
  EXPECT_NE(changed.mistakes[0].message.find("(axes)"), std::string::npos);
}

TEST_F(SettingsChange, GivesTheMountingOfASlotToNoOther) {
  SetupForm without_first = page();
  without_first.slots.erase(without_first.slots.begin());
  SetupForm renamed = page();
  renamed.slots[0].name = "another";
  for (const SetupForm& form : {without_first, renamed}) {
    const SettingsDraft changed = draft(form);
    ASSERT_EQ(changed.mistakes.size(), 1U);
    EXPECT_EQ(changed.mistakes[0].field, "slots.0.name");
  }
  SetupForm other_port = page();
  other_port.slots[0].address.port = 4009;
  const SettingsDraft changed = draft(other_port);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_EQ(changed.toml, with(written_by_hand(), "port = 4001\n", "port = 4009\n"));
}

TEST_F(SettingsChange, WritesANewPasswordToAnotherFileHoweverTheOldOneIsSpelled) {
  for (const std::string& in_use : {std::string("./mail.password"), (folder_ / "mail.password").string()}) {
    write("mail.password", "hunter2\n");
    const std::string text = with(written_by_hand(), "\"old.password\"", "\"" + in_use + "\"");
    SetupForm form = answers(text);
    form.mail->password_file.clear();
    form.mail->password = "hunter3";
    const SettingsDraft changed = draft(form, text);
    ASSERT_EQ(changed.new_secrets.size(), 1U);
    EXPECT_NE(changed.new_secrets[0].file, "mail.password");
  }
}

TEST_F(SettingsChange, RefusesWhatNoChangeOfLinesGives) {
  const std::string chamber = "[chamber]  # bought 2019\n";
  std::string text = with(written_by_hand(), chamber, "");
  for (const char* key : {"map", "host", "port"}) {
    text = with(text, std::string("\n") + key + " = ", std::string("\nchamber.") + key + " = ");
  }
  SetupForm form = answers(text);
  form.mail->password_file.clear();
  form.chamber.address.port.reset();
  const SettingsDraft changed = draft(form, text);
  ASSERT_EQ(changed.mistakes.size(), 1U);
  EXPECT_NE(changed.mistakes[0].message.find("no change of single lines"), std::string::npos);
}

TEST_F(SettingsChange, TellsTheMistakesAtTheirFields) {
  SetupForm form = page();
  form.slots[1].address = form.slots[0].address;
  const SettingsDraft changed = draft(form);
  ASSERT_EQ(changed.mistakes.size(), 1U);
  EXPECT_EQ(changed.mistakes[0].field, "slots.1.port");
}

TEST_F(SettingsChange, KeepsAPasswordForItsServerAndUserAlone) {
  SetupForm form = page();
  form.mail->port = 2525;
  const SettingsDraft same = draft(form);
  ASSERT_TRUE(same.mistakes.empty()) << same.mistakes[0].message;
  EXPECT_NE(same.toml.find("password_file = \"old.password\""), std::string::npos);
  EXPECT_TRUE(same.new_secrets.empty());
  for (std::string EnteredMail::* member : {&EnteredMail::host, &EnteredMail::user}) {
    SetupForm other = page();
    (*other.mail).*member = "elsewhere";
    const SettingsDraft refused = draft(other);
    ASSERT_FALSE(refused.mistakes.empty());
    EXPECT_EQ(refused.mistakes[0].field, "mail.password");
  }
}

TEST_F(SettingsChange, WritesANewPasswordBesideTheOneOfBefore) {
  SetupForm form = page();
  form.mail->password = "hunter3";
  const SettingsDraft changed = draft(form);
  ASSERT_TRUE(changed.mistakes.empty()) << changed.mistakes[0].message;
  EXPECT_EQ(changed.differences.find("hunter"), std::string::npos);
  ASSERT_TRUE(write_settings(file_, written_by_hand(), changed));
  EXPECT_EQ(read("station.toml"), with(written_by_hand(), "old.password", "mail.password"));
  EXPECT_EQ(read("station.toml.before"), written_by_hand());
  EXPECT_EQ(read("mail.password"), "hunter3\n");
  EXPECT_EQ(read("old.password"), "hunter2\n");
  for (const char* name : {"station.toml", "station.toml.before", "mail.password"}) {
    EXPECT_EQ(fs::status(folder_ / name).permissions(), fs::perms(0600)) << name;
  }
}

TEST_F(SettingsChange, SaysWhichSecretCannotBeRead) {
  ::chmod((folder_ / "old.password").c_str(), 0644);
  SetupForm form = page();
  const auto mistakes = keep_secrets(form, answers(), folder_);
  ASSERT_EQ(mistakes.size(), 1U);
  EXPECT_EQ(mistakes[0].field, "mail.password");
}

TEST_F(SettingsChange, GivesNoTokenToAnotherAddress) {
  const std::string text =
      written_by_hand() + "\n[alarms.webhook]\nurl = \"https://chat.example/hooks/s3cret\"\ntoken_file = \"t\"\n";
  write("t", "t0ken\n");
  SetupForm form = answers(text);
  form.mail->password_file.clear();
  form.webhook = EnteredWebhook();
  EXPECT_EQ(draft(form, text).toml, text) << "an address that stands in the file stays there";
  form.webhook = EnteredWebhook{.url = "https://elsewhere.example/hooks", .token = ""};
  const SettingsDraft moved = draft(form, text);
  ASSERT_TRUE(moved.mistakes.empty()) << moved.mistakes[0].message;
  EXPECT_EQ(moved.toml.find("token_file"), std::string::npos) << moved.toml;
  EXPECT_NE(moved.toml.find("[alarms.webhook]\nurl_file = \"webhook.url\"\n"), std::string::npos) << moved.toml;
  EXPECT_EQ(moved.differences.find("s3cret"), std::string::npos) << moved.differences;
}

TEST_F(SettingsChange, DoesNotShowAStationInPart) {
  const std::string mixed =
      with(written_by_hand(), "unit_type = \"mti-300\"\n# the second", "unit_type = \"vn-200\"\n# the second");
  const auto refused = answers_in(mixed, file_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("slot B is for units of another type"), std::string::npos);
  EXPECT_FALSE(answers_in(with(written_by_hand(), "port = 502", "pord = 502"), file_));
}

}  // namespace
}  // namespace soak::station
