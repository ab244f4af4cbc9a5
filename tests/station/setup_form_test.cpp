// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "settings/reader.h"
#include "station/config/config_place.h"
#include "station/setup/setup_check.h"
#include "station/setup/setup_choices.h"

namespace soak::station {
namespace {

SetupForm small_form() {
  SetupForm form;
  form.chamber = {.map = "/maps/a.toml", .address = {.host = "10.0.0.7", .port = 502}};
  form.unit_type = "mti-300";
  form.decoder = "xsens";
  form.slots = {{.name = "A", .address = {.device = "/dev/ttyUSB0", .baud = 921600}, .unit = "SN1"},
                {.name = "B", .address = {.host = "10.0.0.9", .port = 4001}}};
  return form;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(SetupForm, SaysOfEachLineWhatWasEnteredThere) {
  const SetupText text = setup_text(small_form());
  const auto lines = lines_of(text.toml);
  ASSERT_EQ(lines.size(), text.fields.size());
  const auto field_of = [&](const std::string& line) {
    const auto found = std::find(lines.begin(), lines.end(), line);
    return found == lines.end() ? "no such line" : text.fields[static_cast<std::size_t>(found - lines.begin())];
  };
  EXPECT_EQ(field_of("[chamber]"), "chamber");
  EXPECT_EQ(field_of("host = \"10.0.0.7\""), "chamber.host");
  EXPECT_EQ(field_of("baud = 921600"), "slots.0.baud");
  EXPECT_EQ(field_of("port = 4001"), "slots.1.port");
  EXPECT_EQ(field_of("unit_type = \"mti-300\""), "unit_type");
  EXPECT_EQ(field_of("decoder = \"xsens\""), "decoder");
}

TEST(SetupForm, WritesOfThePlaceWhatIsKnown) {
  SetupForm form = small_form();
  form.site = EnteredSite{.latitude_deg = -33.5, .height_m = 40.0, .gravity_mps2 = {}};
  const SetupText text = setup_text(form);
  EXPECT_NE(text.toml.find("\n[site]\nlatitude_deg = -33.5\nheight_m = 40\n"), std::string::npos) << text.toml;
  EXPECT_EQ(text.toml.find("gravity_mps2"), std::string::npos);
  EXPECT_NE(std::find(text.fields.begin(), text.fields.end(), "site.latitude_deg"), text.fields.end());
}

TEST(SetupForm, NamesTheFilesOfSecretsAndHoldsNone) {
  SetupForm form = small_form();
  form.mail = EnteredMail{.host = "smtp.lab.example",
                          .security = "tls",
                          .port = {},
                          .from = "a@b",
                          .to = {"c@d"},
                          .user = "soak",
                          .password = "hunter2"};
  form.webhook = EnteredWebhook{"https://chat.example/hooks/s3cret", "t0ken"};
  const SetupText text = setup_text(form);
  for (const char* secret : {"hunter2", "s3cret", "t0ken"}) EXPECT_EQ(text.toml.find(secret), std::string::npos);
  for (const char* line :
       {"password_file = \"mail.password\"\n", "url_file = \"webhook.url\"\n", "token_file = \"webhook.token\"\n"}) {
    EXPECT_NE(text.toml.find(line), std::string::npos) << text.toml;
  }
  EXPECT_NE(std::find(text.fields.begin(), text.fields.end(), "mail.password"), text.fields.end());
  EXPECT_EQ(secrets_of(form).size(), 3U);
  const auto wrong = [&] {
    std::vector<std::string> fields;
    for (const SetupMistake& mistake : check_setup(form, "station.toml").mistakes) fields.push_back(mistake.field);
    return fields;
  };
  const auto is_told = [&](const char* field) {
    const auto fields = wrong();
    return std::find(fields.begin(), fields.end(), field) != fields.end();
  };
  EXPECT_FALSE(is_told("mail.password") || is_told("webhook.url"));
  form.mail->password.clear();
  form.webhook->url = "http://chat.example/hooks/s3cret";
  EXPECT_TRUE(is_told("mail.password"));
  EXPECT_TRUE(is_told("webhook.url")) << "a token is sent over TLS only";
}

TEST(SetupForm, WritesWhatSwitchesTheUnits) {
  SetupForm form = small_form();
  form.slots[0].power_output = 3;
  form.slots[0].supply_v = 12.5;
  form.purge_below_c = 5.0;
  form.power =
      EnteredPower{.from = {}, .usb_hubs = {}, .controller = {.map = "/maps/r.toml", .address = {.host = "r"}}};
  std::string text = setup_text(form).toml;
  EXPECT_NE(text.find("\n[power]\nmap = \"/maps/r.toml\"\nhost = \"r\"\n"), std::string::npos) << text;
  EXPECT_NE(text.find("power_output = 3\nsupply_v = 12.5\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n[purge]\nbelow_c = 5\n"), std::string::npos) << text;
  form.power->usb_hubs = {"1-4", "1-4.3"};
  text = setup_text(form).toml;
  EXPECT_NE(text.find("\n[power]\nusb_hubs = [\"1-4\", \"1-4.3\"]\n"), std::string::npos) << text;
  form.power->from = "chamber";
  EXPECT_NE(setup_text(form).toml.find("\n[power]\nfrom = \"chamber\"\n"), std::string::npos);
}

TEST(SetupForm, KeepsWhatIsNotEnteredOutOfTheText) {
  const std::string text = setup_text(small_form()).toml;
  for (const char* key : {"[fixture]", "[power]", "[purge]", "power_output", "[alarms", "parity", "stop_bits",
                          "unit = 1", "unit = \"\""}) {
    EXPECT_EQ(text.find(key), std::string::npos) << key;
  }
}

/// Whatever bytes a value has, it stays within its quotes and is read back as it was.
TEST(SetupForm, ReadsBackAnyValueAndMakesNoLineOfIt) {
  std::string every;
  for (int byte = 1; byte < 0x80; ++byte) every += static_cast<char>(byte);
  for (const std::string& value :
       {every, std::string("a\"\nlisten = \"0.0.0.0:1"), std::string("\\"), std::string("\\u0022"),
        std::string("\"\"\""), std::string("]\n[tls]\n"), std::string("µ°C")}) {
    const std::string quoted = toml_quoted(value);
    EXPECT_EQ(quoted.find('\n'), std::string::npos);
    const auto read =
        settings::read("a = " + quoted + "\n", "t", [](const settings::Table& root) { return root.text("a"); });
    ASSERT_TRUE(read) << quoted;
    EXPECT_EQ(*read, value);
    SetupForm form = small_form();
    form.slots[0].address.device = value;
    form.slots[0].unit = value;
    form.chamber.map = value;
    EXPECT_EQ(lines_of(setup_text(form).toml).size(), lines_of(setup_text(small_form()).toml).size());
  }
}

class SetupFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/soak-setup-XXXXXX";
    folder_ = mkdtemp(name);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::filesystem::path& file, const std::string& text = "") {
    std::filesystem::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }

  std::filesystem::path folder_;
};

TEST_F(SetupFiles, WritesAConfigurationOnceAndLeavesNothingElseBehind) {
  const auto file = folder_ / "station.toml";
  ASSERT_TRUE(write_new_config(file, "a = 1\n", {{"mail.password", "first"}}));
  const auto again = write_new_config(file, "a = 2\n", {{"mail.password", "second"}});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(again.error().where, "state");
  EXPECT_EQ(settings::read_text(file.string()).value_or(""), "a = 1\n");
  const auto secret = folder_ / "mail.password";
  EXPECT_EQ(settings::read_text(secret.string()).value_or(""), "first\n");
  EXPECT_EQ(std::filesystem::status(secret).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 2);
}

TEST_F(SetupFiles, LooksIntoTheFolderOfTheServiceWhereTheFileIsTheTemplateAndNoFolderIsNamed) {
  write("etc/station.toml", config_template());
  const auto file = folder_ / "etc/station.toml";
  const auto service = folder_ / "service";
  ::setenv("SOAK_DATA", (folder_ / "own").c_str(), 1);
  const auto before = place_of_config(file, "", service);
  ASSERT_TRUE(before);
  EXPECT_FALSE(before->is_there);
  EXPECT_EQ(before->searched, (std::vector<std::filesystem::path>{folder_ / "own", service}));
  EXPECT_NE(no_config_at(*before).message.find(file.string() + " is still the template"), std::string::npos);
  write("service/station.toml", "a = 1\n");
  const auto found = place_of_config(file, "", service);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_there);
  EXPECT_EQ(found->file, service / "station.toml");
  EXPECT_EQ(found->data, service);
  const auto named = place_of_config(file, (folder_ / "own").string(), service);
  ASSERT_TRUE(named);
  EXPECT_FALSE(named->is_there);
  write("own/station.toml", "a = 1\n");
  const auto own = place_of_config(file, "", service);
  ASSERT_TRUE(own);
  EXPECT_EQ(own->file, folder_ / "own/station.toml");
  ::unsetenv("SOAK_DATA");
}

TEST_F(SetupFiles, OffersAdaptersByTheNameThatStaysAndNoPortWithoutHardware) {
  for (const char* node : {"ttyUSB0", "ttyUSB1", "ttyS0", "ttyS1", "tty1", "ttyUSB", "null"})
    write(std::filesystem::path("dev") / node);
  std::filesystem::create_directories(folder_ / "dev/serial/by-id");
  std::filesystem::create_symlink("../../ttyUSB1", folder_ / "dev/serial/by-id/usb-FTDI-if00");
  write("class/ttyS0/type", "4\n");
  write("class/ttyS1/type", "0\n");
  std::vector<std::string> found;
  for (const SerialPort& port : serial_ports(folder_ / "dev", folder_ / "class")) {
    found.push_back(std::filesystem::path(port.device).lexically_relative(folder_ / "dev").string() + " " +
                    std::filesystem::path(port.node).filename().string());
  }
  EXPECT_EQ(found, (std::vector<std::string>{"serial/by-id/usb-FTDI-if00 ttyUSB1", "ttyS0 ttyS0", "ttyUSB0 ttyUSB0"}));
}

}  // namespace
}  // namespace soak::station
