// SPDX-License-Identifier: Apache-2.0
#include "station/config/station_config.h"
#include "tests/errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace soak::station {
namespace {

const std::filesystem::path kShippedProcedures = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures";

/// A folder with a station's configuration that refers to the shipped maps by relative paths.
class StationConfigFile : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/soak-config-XXXXXX";
    folder_ = mkdtemp(name);
    std::filesystem::create_directory_symlink(kShippedProcedures, folder_ / "procedures");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  base::Result<StationConfig> read(const std::string& text) {
    file_ = folder_ / "station.toml";
    std::ofstream(file_) << text;
    return read_station_config(file_);
  }

  /// Message of the refusal with the place before it.
  std::string refusal(const std::string& text) {
    const auto config = read(text);
    EXPECT_FALSE(config) << text;
    return config ? "" : config.error().where + ": " + config.error().message;
  }

  [[nodiscard]] std::string place(int line) const { return fmt::format("{}:{}: ", file_.string(), line); }

  std::filesystem::path folder_;
  std::filesystem::path file_;
};

constexpr const char* kChamber = R"([chamber]
map = "procedures/chambers/watlow-f4t.toml"
host = "127.0.0.1"
port = 1502
)";

constexpr const char* kFull = R"(listen = "0.0.0.0:9000"
allowed_hosts = ["Lab-PC", "soak.lab.example"]
data = "lab/data"
[clock]
rate = 1000
[chamber]
map = "procedures/chambers/watlow-f4t.toml"
host = "10.0.0.7"
port = 1502
unit = 3
[fixture]
map = "procedures/fixtures/modbus-positioner.toml"
host = "10.0.0.8"
port = 1503
[power]
map = "procedures/power/modbus-relay.toml"
device = "/dev/ttyS1"
baud = 19200
parity = "E"
stop_bits = 2
[unit_types]
folder = "procedures/units"
[site]
latitude_deg = -35.3
height_m = 580
azimuth_deg = 12
[room]
temp_c = 22
dew_point_c = 11
[[slot]]
name = "1"
host = "10.0.0.9"
port = 4001
axes = ["+Y", "-X", "+Z"]
power_output = 1
unit = "0380A001"
unit_type = "mti-300"
[[slot]]
name = "left"
device = "/dev/ttyUSB0"
baud = 921600
)";

constexpr const char* kSlot = "[[slot]]\nname = \"1\"\ndevice = \"/dev/ttyUSB0\"\n";

TEST_F(StationConfigFile, AKeyOfTheTopThatStandsInASectionIsToldWhereItBelongs) {
  const std::string message = refusal(std::string(kChamber) + kSlot + "listen = \"0.0.0.0:8088\"\nbogus = 1\n");
  EXPECT_TRUE(base::mentions(message, {place(8) + "unknown key 'listen' here: it belongs above the first [section]"}));
  EXPECT_TRUE(message.ends_with("unknown key 'bogus'")) << message;
}

TEST_F(StationConfigFile, WhoIsToldOfAlarmsIsRead) {
  const auto config = read(std::string(kChamber) + kSlot + R"([alarms.mail]
host = "smtp.lab.example"
security = "tls"
from = "soak@lab.example"
to = ["eva@lab.example", "otto@lab.example"]
user = "soak"
password_file = "secrets/mail"
[alarms.webhook]
url = "http://127.0.0.1:9000/hook"
token_file = "/etc/token"
)");
  ASSERT_TRUE(config) << config.error().message;
  ASSERT_TRUE(config->alarms.mail);
  EXPECT_EQ(config->alarms.mail->port, 465);
  EXPECT_EQ(config->alarms.mail->to.size(), 2U);
  EXPECT_EQ(config->alarms.mail->password_file, folder_ / "secrets" / "mail");
  ASSERT_TRUE(config->alarms.webhook);
  EXPECT_EQ(config->alarms.webhook->token_file, "/etc/token");
  const auto nobody = read(std::string(kChamber) + kSlot);
  ASSERT_TRUE(nobody);
  EXPECT_FALSE(nobody->alarms.mail || nobody->alarms.webhook);
}

TEST_F(StationConfigFile, WhatCannotTellAnybodyOfAlarmsIsRefused) {
  const std::string begin = std::string(kChamber) + kSlot;
  const std::string mail = begin + "[alarms.mail]\nhost = \"smtp.lab.example\"\nfrom = \"soak@lab.example\"\n";
  const std::string whole = mail + "to = [\"eva@lab.example\"]\n";
  EXPECT_NE(refusal(mail).find("'to'"), std::string::npos);
  for (const char* address :
       {"eva", "eva@", "@lab", "e va@lab", "eva@lab\\r\\nBcc: x@y", "<eva@lab>", "eva@lab, x@y"}) {
    EXPECT_NE(refusal(mail + "to = [\"" + address + "\"]\n").find("address"), std::string::npos) << address;
  }
  EXPECT_NE(refusal(whole + "user = \"soak\"\n").find("password_file"), std::string::npos);
  EXPECT_NE(refusal(whole + "user = \"soak\"\npassword_file = \"p\"\nsecurity = \"none\"\n").find("TLS"),
            std::string::npos);
  EXPECT_NE(refusal(whole + "port = 0\n").find("port"), std::string::npos);
  const std::string hook = begin + "[alarms.webhook]\n";
  EXPECT_NE(refusal(hook).find("url_file"), std::string::npos);
  for (const char* url : {"chat.example", "ftp://chat.example/", "https://", "https://eva:secret@chat.example/",
                          "https://chat.example/a b"}) {
    EXPECT_NE(refusal(hook + "url = \"" + url + "\"\n").find("must be an address"), std::string::npos) << url;
  }
  EXPECT_NE(refusal(hook + "url = \"http://chat.example/\"\ntoken_file = \"t\"\n").find("https://"), std::string::npos);
}

TEST_F(StationConfigFile, UsbAddressesAndDecodersAreRead) {
  const auto config = read(std::string(kChamber) + R"([[slot]]
name = "1"
usb = "2639:0013"
usb_path = "1-4.2"
[[slot]]
name = "2"
usb = "0403:6001"
usb_serial = "A50285BI"
baud = 38400
decoder = "ahrs400"
[[slot]]
name = "3"
device = "/dev/ttyS0"
decoder = "vectornav"
)");
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  const auto& xsens = std::get<hal::UsbAddress>(config->slots[0].address);
  EXPECT_EQ(xsens.vendor, 0x2639);
  EXPECT_EQ(xsens.product, 0x0013);
  EXPECT_EQ(xsens.path, "1-4.2");
  EXPECT_EQ(config->slots[0].decoder, hal::UnitDecoder::xsens);
  const auto& chip = std::get<hal::UsbAddress>(config->slots[1].address);
  EXPECT_EQ(chip.vendor, 0x0403);
  EXPECT_EQ(chip.serial, "A50285BI");
  EXPECT_EQ(chip.baud, 38400);
  EXPECT_EQ(config->slots[1].decoder, hal::UnitDecoder::ahrs400);
  EXPECT_EQ(config->slots[2].decoder, hal::UnitDecoder::vectornav);
}

TEST_F(StationConfigFile, UsbAddressesThatNameNoDeviceAreRefused) {
  for (const char* usb : {"2639", "2639:13", "2639-0013", "xxxx:0013", "2639:0013:1", "263F:0013", ""}) {
    EXPECT_NE(refusal(std::string(kChamber) + "[[slot]]\nname = \"1\"\nusb = \"" + usb + "\"\n").find("'usb'"),
              std::string::npos)
        << usb;
  }
}

TEST_F(StationConfigFile, TwoUsbDevicesOfOneKindMustBeToldApart) {
  const std::string any =
      std::string(kChamber) + "[[slot]]\nname = \"1\"\nusb = \"2639:0013\"\n[[slot]]\nname = \"2\"\n";
  EXPECT_TRUE(base::mentions(refusal(any + "usb = \"2639:0013\"\nusb_path = \"1-1\"\n"), {"usb_serial", "usb_path"}));
  EXPECT_TRUE(read(any + "usb = \"2639:0012\"\n"));
}

TEST_F(StationConfigFile, ALinkCarriesTheRangesOfTheUnitType) {
  Slot slot;
  slot.decoder = hal::UnitDecoder::ahrs400;
  const auto link = link_of(slot, {.gyro_range_dps = 200.0, .accel_range_mps2 = 39.2266});
  EXPECT_EQ(link.decoder, hal::UnitDecoder::ahrs400);
  EXPECT_DOUBLE_EQ(link.ranges.rate_dps, 200.0);
  EXPECT_DOUBLE_EQ(link.ranges.accel_g, 4.0);
}

TEST_F(StationConfigFile, EveryKeyIsRead) {
  const auto config = read(kFull);
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  EXPECT_EQ(config->listen, "0.0.0.0:9000");
  EXPECT_EQ(config->allowed_hosts, (std::vector<std::string>{"lab-pc", "soak.lab.example"}));
  EXPECT_EQ(config->data, folder_ / "lab/data");
  EXPECT_EQ(config->clock_rate, 1000.0);
  const auto& chamber = config->chamber;
  EXPECT_EQ(chamber.name, "Watlow F4T");
  EXPECT_EQ(std::get<hal::TcpAddress>(chamber.link.address).host, "10.0.0.7");
  EXPECT_EQ(std::get<hal::TcpAddress>(chamber.link.address).port, 1502);
  EXPECT_EQ(chamber.link.unit, 3);
  EXPECT_EQ(chamber.link.max_block, 48) << "all but the address stays as the map says";
  ASSERT_TRUE(config->fixture);
  const auto* power = std::get_if<hal::DeviceMap>(&config->power);
  ASSERT_NE(power, nullptr);
  EXPECT_EQ(config->fixture->positions.size(), 6u);
  const auto& serial = std::get<hal::SerialAddress>(power->link.address);
  EXPECT_EQ(serial.device, "/dev/ttyS1");
  EXPECT_EQ(serial.baud, 19200);
  EXPECT_EQ(serial.parity, 'E');
  EXPECT_EQ(serial.stop_bits, 2);
  EXPECT_EQ(config->unit_types, folder_ / "procedures/units");
  EXPECT_EQ(config->site, (calib::Site{.latitude_deg = -35.3, .height_m = 580.0, .azimuth_deg = 12.0}));
  EXPECT_EQ(config->room_c, 22.0);
  EXPECT_EQ(config->dew_point_c, 11.0);
  EXPECT_FALSE(config->dew_point_assumed);
  ASSERT_EQ(config->slots.size(), 2u);
  const Slot& first = config->slots[0];
  EXPECT_EQ(std::get<hal::TcpAddress>(first.address).port, 4001);
  EXPECT_EQ(first.axes, (std::array<std::string, 3>{"+Y", "-X", "+Z"}));
  EXPECT_EQ(first.power_output, 1);
  EXPECT_EQ(first.unit, "0380A001");
  EXPECT_EQ(first.unit_type, "mti-300");
  EXPECT_EQ(std::get<hal::SerialAddress>(config->slots[1].address).baud, 921600);
}

TEST_F(StationConfigFile, WithoutFixtureAndPowerBothAreDoneByHand) {
  const auto config = read(fmt::format("{}[[slot]]\nname = \"1\"\nhost = \"a\"\nport = 1\n", kChamber));
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  EXPECT_FALSE(config->fixture);
  EXPECT_TRUE(std::holds_alternative<PowerByHand>(config->power));
  EXPECT_FALSE(config->purge_below_c);
  EXPECT_EQ(config->clock_rate, 1.0);
  EXPECT_EQ(config->listen, "127.0.0.1:8088");
  EXPECT_TRUE(config->data.empty());
}

TEST_F(StationConfigFile, ADewPointThatNobodyStatesIsAssumedAndLiesNotAboveTheRoom) {
  const std::string begin = std::string(kChamber) + kSlot;
  const auto unsaid = read(begin);
  ASSERT_TRUE(unsaid);
  EXPECT_TRUE(unsaid->dew_point_assumed);
  EXPECT_EQ(unsaid->dew_point_c, 15.0);
  const auto cool = read(begin + "[room]\ntemp_c = 12\n");
  ASSERT_TRUE(cool) << cool.error().message;
  EXPECT_TRUE(cool->dew_point_assumed);
  EXPECT_EQ(cool->dew_point_c, 12.0);
}

TEST_F(StationConfigFile, AChamberThatSpeaksTextIsNamedLikeAnyOther) {
  const std::string slot = "[[slot]]\nname = \"1\"\nhost = \"a\"\nport = 1\n";
  const std::string section = "[chamber]\nmap = \"procedures/chambers/espec-p300.toml\"\n";
  auto config = read(section + "host = \"10.0.0.7\"\n" + slot);
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  const auto& tcp = std::get<hal::TcpAddress>(config->chamber.link.address);
  EXPECT_EQ(tcp.host, "10.0.0.7");
  EXPECT_EQ(tcp.port, 10001) << "the map's own";
  config = read(section + "device = \"/dev/ttyS0\"\nbaud = 19200\n" + slot);
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  const auto& serial = std::get<hal::SerialAddress>(config->chamber.link.address);
  EXPECT_EQ(serial.device, "/dev/ttyS0");
  EXPECT_EQ(serial.baud, 19200);
  EXPECT_TRUE(base::mentions(refusal(section + "host = \"h\"\nunit = 3\n" + slot),
                             {fmt::format("{}:4: ", file_.string()), "'unit'"}))
      << "only Modbus has unit numbers";
}

// 'soak chamber probe' takes them from the map as well: what it has found must hold for soakd.
TEST_F(StationConfigFile, ASerialLineIsAsTheMapSaysUnlessTheSectionSaysOtherwise) {
  std::ofstream(folder_ / "even.toml") << R"(name = "even"
kind = "fixture"
positions = ["+X"]
[link]
rtu = "/dev/ttyS7"
baud = 38400
parity = "E"
stop_bits = 2
[quantity]
request = { address = 0, type = "u16", write_function = 6 }
position = { address = 1, type = "u16" }
status = { address = 2, type = "u16", codes = { standing = 0, moving = 1, fault = 2 } }
)";
  const std::string f4 = "[chamber]\nmap = \"procedures/chambers/watlow-f4.toml\"\ndevice = \"/dev/ttyS0\"\n";
  const std::string rest =
      "[fixture]\nmap = \"even.toml\"\ndevice = \"/dev/ttyS1\"\n[[slot]]\nname = \"1\"\ndevice = \"/dev/ttyS2\"\n";
  const auto line_of = [](const hal::DeviceMap& map) { return std::get<hal::SerialAddress>(map.link.address); };
  auto config = read(f4 + rest);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(line_of(config->chamber).baud, 19200);
  EXPECT_EQ(line_of(*config->fixture).device, "/dev/ttyS1");
  EXPECT_EQ(line_of(*config->fixture).baud, 38400);
  EXPECT_EQ(line_of(*config->fixture).parity, 'E');
  EXPECT_EQ(line_of(*config->fixture).stop_bits, 2);
  config = read(f4 + "baud = 9600\n" + rest);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(line_of(config->chamber).baud, 9600);
}

TEST_F(StationConfigFile, AMapThatLacksWhatItsDeviceNeedsIsAMistakeOfTheSection) {
  std::ofstream(folder_ / "lacking.toml") << R"(name = "lacking"
kind = "fixture"
positions = ["+X"]
[link]
tcp = "10.0.0.8"
[quantity]
request = { address = 0, type = "u16", write_function = 6 }
position = { address = 1, type = "u16" }
)";
  const std::string message = refusal(std::string(kChamber) +
                                      "[fixture]\nmap = \"lacking.toml\"\nhost = \"10.0.0.8\"\n"
                                      "[[slot]]\nname = \"1\"\ndevice = \"/dev/ttyS2\"\n");
  EXPECT_TRUE(message.starts_with(place(6))) << message;
  EXPECT_TRUE(base::mentions(message, {"lacking.toml:2: ", "[quantity.status]"}));
}

TEST_F(StationConfigFile, ASupplySaysWhatItsOutputsShallDeliver) {
  const auto config = read(std::string(kChamber) + R"([power]
map = "procedures/power/scpi-supply.toml"
host = "10.0.0.5"
[purge]
below_c = 5
[[slot]]
name = "1"
host = "h"
port = 7
power_output = 3
supply_v = 12
supply_limit_a = 0.4
)");
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  const auto& map = std::get<hal::DeviceMap>(config->power);
  EXPECT_EQ(std::get<hal::TcpAddress>(map.link.address).host, "10.0.0.5");
  EXPECT_EQ(std::get<hal::TcpAddress>(map.link.address).port, 5025) << "the map's own";
  EXPECT_EQ(config->slots[0].supply.voltage_v, 12.0);
  EXPECT_EQ(config->slots[0].supply.limit_a, 0.4);
  EXPECT_EQ(config->purge_below_c, 5.0);
}

TEST_F(StationConfigFile, ASerialPortHasOneOwner) {
  const std::string chamber =
      "[chamber]\nmap = \"procedures/chambers/watlow-f4t.toml\"\ndevice = \"/dev/ttyUSB0\"\nunit = 1\n";
  const auto slot = [](const std::string& port) {
    return "[[slot]]\nname = \"A\"\ndevice = \"" + port + "\"\npower_output = 1\n";
  };
  const auto relay = [](const std::string& port) {
    return "[power]\nmap = \"procedures/power/modbus-relay.toml\"\ndevice = \"" + port + "\"\n";
  };
  EXPECT_TRUE(read(chamber + relay("/dev/ttyUSB1") + slot("/dev/ttyUSB2")));
  EXPECT_TRUE(base::mentions(refusal(chamber + relay("/dev/ttyUSB0") + slot("/dev/ttyUSB2")),
                             {"'/dev/ttyUSB0'", "power", "chamber"}));
  EXPECT_TRUE(base::mentions(refusal(chamber + relay("/dev/ttyUSB1") + slot("/dev/ttyUSB1")),
                             {"'/dev/ttyUSB1'", "slot A", "power"}));
}

TEST_F(StationConfigFile, NoSlotIsAtTheNetworkAddressOfAController) {
  const auto slot = [](const char* host, int port) {
    return fmt::format("[[slot]]\nname = \"A\"\nhost = \"{}\"\nport = {}\npower_output = 1\n", host, port);
  };
  const std::string devices =
      "[chamber]\nmap = \"procedures/chambers/watlow-f4t.toml\"\nhost = \"10.0.0.5\"\nport = 502\nunit = 1\n"
      "[power]\nmap = \"procedures/power/modbus-relay.toml\"\nhost = \"10.0.0.5\"\nport = 502\nunit = 2\n";
  EXPECT_TRUE(read(devices + slot("10.0.0.5", 4001))) << "two controllers behind one gateway";
  EXPECT_TRUE(base::mentions(refusal(devices + slot("10.0.0.5", 502)), {"'10.0.0.5:502'", "slot A", "chamber"}));
}

TEST_F(StationConfigFile, UsbHubsAreNamedByTheirSockets) {
  const std::string slot = "[[slot]]\nname = \"1\"\nhost = \"h\"\nport = 7\npower_output = 102\n";
  const auto power = [&](const std::string& hubs) {
    return std::string(kChamber) + "[power]\nusb_hubs = " + hubs + "\n" + slot;
  };
  const auto config = read(power(R"(["1-4", "1-4.3.1", "usb2"])"));
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  EXPECT_EQ(std::get<hal::UsbHubs>(config->power).paths, (std::vector<std::string>{"1-4", "1-4.3.1", "usb2"}));
  for (const char* hubs : {"[]", R"(["../4"])", R"(["1-4:1.0"])", R"(["1-4", "1-4"])", R"([""])"}) {
    EXPECT_NE(refusal(power(hubs)).find("'usb_hubs'"), std::string::npos) << hubs;
  }
  EXPECT_NE(refusal(power("[\"1-4\"]\nhost = \"h\"")).find("'host'"), std::string::npos);
}

TEST_F(StationConfigFile, OutputsOfTheChamberNeedNoAddressOfTheirOwn) {
  const std::string slot = "[[slot]]\nname = \"1\"\nhost = \"h\"\nport = 7\npower_output = 2\n";
  const auto config = read(std::string(kChamber) + "[power]\nfrom = \"chamber\"\n" + slot);
  ASSERT_TRUE(config) << config.error().where << config.error().message;
  EXPECT_TRUE(std::holds_alternative<PowerFromChamber>(config->power));
  EXPECT_NE(refusal(std::string(kChamber) + "[power]\nfrom = \"fixture\"\n" + slot), "");
  EXPECT_NE(refusal(std::string(kChamber) + "[power]\nfrom = \"chamber\"\nhost = \"h\"\n" + slot), "");
}

TEST_F(StationConfigFile, AVoltageWithoutAnOutputIsRefused) {
  const std::string message =
      refusal(std::string(kChamber) + "[[slot]]\nname = \"1\"\nhost = \"h\"\nport = 7\nsupply_v = 5\n");
  EXPECT_TRUE(base::mentions(message, {"'supply_v'", "'power_output'"}));
}

TEST_F(StationConfigFile, WhatTwoSlotsCannotShareIsRefusedAtTheSecond) {
  const std::string slots = R"([power]
map = "procedures/power/modbus-relay.toml"
host = "127.0.0.1"
[[slot]]
name = "1"
host = "h"
port = 7
power_output = 1
unit = "A"
[[slot]]
name = "1"
host = "h"
port = 7
power_output = 1
unit = "A"
)";
  const std::string message = refusal(kChamber + slots);
  for (const int line : {15, 17, 18, 19}) EXPECT_TRUE(base::mentions(message, {place(line)}));
}

TEST_F(StationConfigFile, EveryMistakeIsReportedWithItsLine) {
  const std::string message = refusal(R"(listen = "8088"
colour = "red"
[clock]
rate = 0
[chamber]
map = "procedures/fixtures/modbus-positioner.toml"
host = "h"
[fixture]
map = "no-such-file.toml"
[site]
latitude_deg = 95
[room]
temp_c = 20
dew_point_c = 21
[unit_types]
folder = "procedures/units"
[[slot]]
name = "1"
axes = ["+Y", "+X", "+Z"]
host = "h"
port = 5
power_output = 2
[[slot]]
name = "2"
device = "/dev/x"
unit_type = "mystery"
decoder = "morse"
)");
  for (const int line : {1, 2, 4, 6, 8, 9, 11, 14, 19, 22, 26, 27}) {
    EXPECT_NE(message.find(place(line)), std::string::npos) << line << "\n" << message;
  }
  EXPECT_NE(message.find("12 "), std::string::npos) << message;
}

TEST_F(StationConfigFile, NamesOfTheStationStandWithoutPort) {
  for (const char* bad : {"lab:8088", "", "http://lab", "*", "a b"}) {
    const std::string line = std::string("allowed_hosts = [\"") + bad + "\"]\n";
    EXPECT_NE(refusal(line + std::string(kChamber)).find("'allowed_hosts'"), std::string::npos) << bad;
  }
}

TEST_F(StationConfigFile, ACertificateIsGivenWithItsKeyAndBesideTheFile) {
  const std::string chamber = std::string(kChamber) + "[[slot]]\nname = \"A\"\nhost = \"127.0.0.1\"\nport = 9000\n";
  const auto config = read(chamber + "[tls]\ncertificate = \"lab.crt\"\nkey = \"/etc/lab.key\"\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->tls_certificate, folder_ / "lab.crt");
  EXPECT_EQ(config->tls_key, "/etc/lab.key");
  EXPECT_NE(refusal(chamber + "[tls]\ncertificate = \"lab.crt\"\n").find("key"), std::string::npos);
  EXPECT_NE(refusal(chamber + "[tls]\nkey = \"lab.key\"\n").find("certificate"), std::string::npos);
}

TEST_F(StationConfigFile, AStationNeedsChamberAndSlots) {
  const std::string message = refusal("listen = \"h:1\"\n");
  EXPECT_TRUE(base::mentions(message, {"'chamber'", "[[slot]]"}));
}

using Matrix = std::array<std::array<int, 3>, 3>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

std::string label_of(int x, int y, int z) {
  const int axis = x != 0 ? 0 : y != 0 ? 1 : 2;
  return {x + y + z > 0 ? '+' : '-', static_cast<char>('X' + axis)};
}

/// The 24 rotations of a cube, made of quarter turns; columns are the unit's axes in fixture axes.
std::vector<Matrix> mountings() {
  const Matrix about_x = {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};
  const Matrix about_y = {{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}};
  const Matrix about_z = {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
  std::vector<Matrix> all = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Matrix& turn : {about_x, about_y, about_z}) {
      const Matrix next = product(turn, all[i]);
      if (std::find(all.begin(), all.end(), next) == all.end()) all.push_back(next);
    }
  }
  return all;
}

TEST(UnitPosition, AgreesWithTheRotationMatrixInAll24Mountings) {
  const auto all = mountings();
  ASSERT_EQ(all.size(), 24u);
  for (const Matrix& r : all) {
    Slot slot;
    for (std::size_t axis = 0; axis < 3; ++axis) slot.axes[axis] = label_of(r[0][axis], r[1][axis], r[2][axis]);
    for (std::size_t k = 0; k < 6; ++k) {
      const int sign = k % 2 == 0 ? 1 : -1;
      const std::size_t row = k / 2;
      // Fixture axis k up: up in unit axes is Rᵀ e_k, which is row k of R.
      const std::array<int, 3> up = {sign * r[row][0], sign * r[row][1], sign * r[row][2]};
      const calib::Position position = unit_position(slot, calib::kSixPositionLabels[k]);
      EXPECT_EQ(position.label, label_of(up[0], up[1], up[2]));
      EXPECT_EQ(position, *calib::position_named(position.label));
      for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(position.up[i], up[i]);
    }
  }
}

/// Rows: fixture axes in east, north, up, for axis `row` up (sign) and the next one at a heading.
std::array<std::array<double, 3>, 3> fixture_axes(std::size_t row, int sign, double heading_rad) {
  std::array<std::array<double, 3>, 3> axes{};
  axes[row] = {0.0, 0.0, static_cast<double>(sign)};
  axes[(row + 1) % 3] = {std::sin(heading_rad), std::cos(heading_rad), 0.0};
  axes[(row + 2) % 3] = {-sign * std::cos(heading_rad), sign * std::sin(heading_rad), 0.0};
  return axes;
}

TEST(UnitPosition, TurnsTheHeadingWithTheSlotInAll24Mountings) {
  constexpr double kAzimuth_deg = 35.0;
  for (const Matrix& r : mountings()) {
    Slot slot;
    for (std::size_t axis = 0; axis < 3; ++axis) slot.axes[axis] = label_of(r[0][axis], r[1][axis], r[2][axis]);
    for (std::size_t k = 0; k < 6; ++k) {
      const calib::Position position = unit_position(slot, calib::kSixPositionLabels[k], kAzimuth_deg);
      ASSERT_TRUE(position.azimuth_deg);
      const auto axes = fixture_axes(k / 2, k % 2 == 0 ? 1 : -1, kAzimuth_deg * 3.14159265358979 / 180.0);
      // The unit's axis after its vertical one, in fixture axes a column of R, in east and north of the place.
      const auto next = static_cast<std::size_t>(position.label[1] - 'X' + 1) % 3;
      double east = 0.0;
      double north = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        east += r[i][next] * axes[i][0];
        north += r[i][next] * axes[i][1];
      }
      const double heading = *position.azimuth_deg * 3.14159265358979 / 180.0;
      EXPECT_NEAR(std::sin(heading), east, 1e-9) << slot.axes[0] << slot.axes[1] << " " << position.label;
      EXPECT_NEAR(std::cos(heading), north, 1e-9);
    }
  }
}

TEST(UnitPosition, HeadingsComeFromTheFixturesMap) {
  StationConfig config;
  EXPECT_TRUE(positions_of(Slot{}, config).empty());
  config.fixture.emplace();
  config.fixture->positions = {"+X", "-X", "between"};
  EXPECT_TRUE(positions_of(Slot{}, config).empty());
  config.fixture->azimuths_deg = {10.0, 20.0, 30.0};
  const auto positions = positions_of(Slot{}, config);
  ASSERT_EQ(positions.size(), 2U);
  EXPECT_EQ(positions[1].label, "-X");
  EXPECT_EQ(positions[1].azimuth_deg, 20.0);
}

/// A face that leans by a towards the fixture's next axis and by b towards the one after it; the unit sees its up
/// turned by its slot.
TEST(UnitPosition, TurnsTheLeanOfAFaceWithTheSlotInAll24Mountings) {
  constexpr double kTan_a = 0.0034906726;   // 0.2°
  constexpr double kTan_b = -0.0087268678;  // -0.5°
  StationConfig config;
  config.fixture.emplace();
  for (const auto label : calib::kSixPositionLabels) {
    config.fixture->positions.emplace_back(label);
    config.fixture->leans_deg[std::string(label)] = {0.2, -0.5};
  }
  for (const Matrix& r : mountings()) {
    Slot slot;
    for (std::size_t axis = 0; axis < 3; ++axis) slot.axes[axis] = label_of(r[0][axis], r[1][axis], r[2][axis]);
    const auto positions = positions_of(slot, config);
    ASSERT_EQ(positions.size(), 6U);
    for (std::size_t k = 0; k < 6; ++k) {
      std::array<double, 3> up{};
      up[k / 2] = k % 2 == 0 ? 1.0 : -1.0;
      up[(k / 2 + 1) % 3] = kTan_a;
      up[(k / 2 + 2) % 3] = kTan_b;
      const double length = std::sqrt(1.0 + kTan_a * kTan_a + kTan_b * kTan_b);
      EXPECT_EQ(positions[k].label, unit_position(slot, calib::kSixPositionLabels[k]).label);
      EXPECT_FALSE(positions[k].azimuth_deg);
      for (std::size_t i = 0; i < 3; ++i) {
        const double expected = (r[0][i] * up[0] + r[1][i] * up[1] + r[2][i] * up[2]) / length;
        EXPECT_NEAR(positions[k].up[i], expected, 1e-9) << positions[k].label;
      }
    }
  }
}

TEST(UnitPosition, AnUnknownLabelGivesNone) { EXPECT_TRUE(unit_position(Slot{}, "up").label.empty()); }

}  // namespace
}  // namespace soak::station
