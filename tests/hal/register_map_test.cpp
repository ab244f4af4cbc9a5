// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/device_map.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "hal/devices/chamber.h"
#include "hal/devices/fixture.h"
#include "hal/devices/unit_power.h"
#include "tests/errors.h"
#include "tests/hal/map_samples.h"

namespace soak::hal {
namespace {

/// A map without mistakes, of 12 lines; `more` begins in line 13.
std::string chamber_map(const std::string& more) {
  return "name = \"rig\"\n"
         "kind = \"chamber\"\n"
         "[link]\n"
         "tcp = \"chamber.lab:1502\"\n"
         "[quantity.set_point_c]\n"
         "address = 300\n"
         "type = \"i16\"\n"
         "scale = 0.1\n"
         "write_function = 6\n"
         "min = -70\n"
         "max = 180\n"
         "# end\n" +
         more;
}

using test::lacks_for_a_device;
using test::Mistake;
using test::refusal;

TEST(RegisterMap, ReadsEveryKey) {
  const auto map = parse_device_map(R"(
name = "full"
kind = "chamber"
[link]
rtu = "/dev/ttyUSB0"
baud = 19200
parity = "E"
stop_bits = 2
unit = 17
response_timeout_s = 3
gap_s = 0.05
max_block = 32
poll_s = 2
[quantity.air_c]
address = 0x64
type = "i16"
decimals_register = 606
read_function = 4
[quantity.set_point_c]
address = 32772
type = "f32"
word_order = "high_first"
scale = 2
write_function = 16
min = -40
max = 150
[quantity.control_mode]
address = 273
type = "u16"
write_function = 6
codes = { auto = 0, off = 1 }
[quantity.event]
address = 2000
type = "u16"
write_function = 6
[[probe]]
name = "units"
address = 901
type = "i16"
expected = [1, -1]
otherwise = "set Celsius"
link = "rtu"
[action]
start = [{ quantity = "event", value = 1, delay_s = 2 }, { quantity = "control_mode", code = "auto" }]
[[alarm]]
name = "sensor break"
addresses = [74, 75]
mask = 0x20
outputs_off = true
[[alarm]]
name = "high"
addresses = [106]
active = [1, 2]
[[alarm]]
name = "low"
addresses = [110]
inactive = [0]
[write_policy]
only_on_change = false
read_back = false
)",
                                    "full.toml");
  ASSERT_TRUE(map) << map.error().message;
  test::expect_common_keys(*map);
  const auto& line = std::get<SerialAddress>(map->link.address);
  EXPECT_EQ(line.parity, 'E');
  EXPECT_EQ(line.stop_bits, 2);
  EXPECT_EQ(map->link.unit, 17);
  EXPECT_EQ(map->link.response_timeout_s, 3.0);
  EXPECT_EQ(map->link.gap_s, 0.05);
  EXPECT_EQ(map->link.max_block, 32);
  EXPECT_EQ(map->link.poll_s, 2.0);
  const Quantity& air = map->quantities.at("air_c");
  EXPECT_EQ(air.modbus.address, 100);
  EXPECT_EQ(air.modbus.type, RegisterType::i16);
  EXPECT_EQ(air.modbus.decimals_register, 606);
  EXPECT_EQ(air.modbus.read_function, 4);
  EXPECT_FALSE(air.modbus.write_function);
  const Quantity& set_point = map->quantities.at("set_point_c");
  EXPECT_EQ(set_point.modbus.type, RegisterType::f32);
  EXPECT_EQ(set_point.modbus.word_order, WordOrder::high_first);
  EXPECT_EQ(set_point.modbus.scale, 2.0);
  EXPECT_EQ(set_point.modbus.write_function, 16);
  EXPECT_EQ(map->quantities.at("control_mode").codes, (std::map<std::string, int>{{"auto", 0}, {"off", 1}}));
  ASSERT_EQ(map->probes.size(), 1U);
  EXPECT_EQ(map->probes[0].modbus.type, RegisterType::i16);
  EXPECT_EQ(map->probes[0].modbus.expected, (std::vector<int>{1, -1}));
  EXPECT_EQ(map->probes[0].otherwise, "set Celsius");
  EXPECT_EQ(map->probes[0].link, LinkKind::serial);
  const auto& start = map->actions.at("start");
  ASSERT_EQ(start.size(), 2U);
  EXPECT_EQ(start[0].quantity, "event");
  EXPECT_EQ(start[0].value, 1.0);
  EXPECT_EQ(start[0].delay_s, 2.0);
  EXPECT_EQ(start[1].value, 0.0) << "the code of auto";
  ASSERT_EQ(map->alarms.size(), 3U);
  EXPECT_EQ(map->alarms[0].modbus.addresses, (std::vector<int>{74, 75}));
  EXPECT_EQ(map->alarms[0].modbus.mask, 0x20);
  EXPECT_TRUE(map->alarms[0].outputs_off);
  EXPECT_EQ(map->alarms[1].modbus.active, (std::vector<int>{1, 2}));
  EXPECT_FALSE(map->alarms[1].outputs_off);
  EXPECT_EQ(map->alarms[2].modbus.inactive, (std::vector<int>{0}));
}

TEST(RegisterMap, WhatIsAbsentHasItsDefault) {
  const auto map = parse_device_map(chamber_map(""), "m.toml");
  ASSERT_TRUE(map) << map.error().message;
  test::expect_common_defaults(*map);
  EXPECT_EQ(std::get<TcpAddress>(map->link.address).port, 1502);
  EXPECT_EQ(map->link.unit, 1);
  EXPECT_EQ(map->link.response_timeout_s, 1.0);
  EXPECT_FALSE(map->link.gap_s);
  EXPECT_EQ(map->link.max_block, 32);
  const Quantity& set_point = map->quantities.at("set_point_c");
  EXPECT_EQ(set_point.modbus.read_function, 3);
  EXPECT_FALSE(set_point.modbus.decimals_register);
}

TEST(RegisterMap, AllMistakesAreToldAtOnceWithTheirLines) {
  EXPECT_TRUE(
      base::mentions_in_order(refusal("name = \"rig\"\n"
                                      "kind = \"chamber\"\n"
                                      "[link]\n"
                                      "tcp = \"host:\"\n"
                                      "unit = 250\n"
                                      "speed = 9600\n"
                                      "[quantity.set_point_c]\n"
                                      "address = \"2782\"\n"
                                      "type = \"f64\"\n"
                                      "[[alarm]]\n"
                                      "name = \"high\"\n"
                                      "addresses = [70000]\n"
                                      "mask = 1\n"),
                              {"m.toml: 6 ", "\nm.toml:4: 'link.tcp'", "\nm.toml:5: 'link.unit'",
                               "\nm.toml:6: ", "'speed'", "\nm.toml:8: 'quantity.set_point_c.address'",
                               "\nm.toml:9: 'quantity.set_point_c.type'", "\nm.toml:12: 'alarm[1].addresses'"}));
}

class RegisterMapMistake : public testing::TestWithParam<Mistake> {};

TEST_P(RegisterMapMistake, IsRefusedWithItsLine) {
  EXPECT_TRUE(test::is_refused_with_its_line(chamber_map(""), GetParam()));
}

INSTANTIATE_TEST_SUITE_P(
    All, RegisterMapMistake,
    testing::Values(
        Mistake{"[quantity.air_x]\naddress = 1\ntype = \"u16\"\n", 13, "'air_x'"},
        Mistake{"[quantity.air_c]\naddress = 65535\ntype = \"f32\"\n", 14, "f32"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"f32\"\nwrite_function = 6\n", 16, "function 16"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"f32\"\ndecimals_register = 2\n", 16, "'decimals_register'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"i16\"\nword_order = \"low_first\"\n", 16, "'word_order'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"i16\"\nscale = 0\n", 16, "'scale'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"i16\"\nread_function = 5\n", 16,
                "'quantity.air_c.read_function'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"i16\"\nwrite_function = 7\n", 16, "'write_function'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"i16\"\nmax = 7\n", 16, "'max'"},
        Mistake{"[quantity.ramp_rate]\naddress = 1\ntype = \"i16\"\nwrite_function = 6\nmin = 2\nmax = 1\n", 17,
                "'min'"},
        Mistake{"[quantity.control_mode]\naddress = 1\ntype = \"u16\"\ncodes = { auto = -1 }\n", 16,
                "'quantity.control_mode.codes.auto'"},
        Mistake{"[quantity.control_mode]\naddress = 1\ntype = \"u16\"\nscale = 10\ncodes = { auto = 1 }\n", 17,
                "'codes'"},
        Mistake{"[[probe]]\nname = \"p\"\naddress = 1\nexpected = []\notherwise = \"o\"\n", 16, "'expected'"},
        Mistake{"[[probe]]\nname = \"p\"\naddress = 1\nexpected = [-1]\notherwise = \"o\"\n", 16,
                "'probe[1].expected'"},
        Mistake{"[[probe]]\nname = \"p\"\naddress = 1\nexpected = [1]\notherwise = \"o\"\nlink = \"usb\"\n", 18,
                "'probe[1].link'"},
        Mistake{"[[probe]]\nname = \"p\"\naddress = 1\nexpected = [1]\n", 13, "'probe[1].otherwise'"},
        Mistake{"[action]\nstrat = [{ quantity = \"set_point_c\", value = 1 }]\n", 14, "'strat'"},
        Mistake{"[action]\nstart = []\n", 14, "'start'"},
        Mistake{"[action]\nstart = [{ quantity = \"heater\", code = \"on\" }]\n", 14, "'heater'"},
        Mistake{"[action]\nstart = [{ quantity = \"set_point_c\", code = \"on\" }]\n", 14, "'on'"},
        Mistake{"[action]\nstart = [{ quantity = \"set_point_c\" }]\n", 14, "'code'"},
        Mistake{"[action]\nstart = [{ quantity = \"set_point_c\", value = 181 }]\n", 14, "'set_point_c'"},
        Mistake{"[action]\nstart = [{ quantity = \"air_c\", value = 1 }]\n"
                "[quantity.air_c]\naddress = 1\ntype = \"u16\"\n",
                14, "'air_c'"},
        Mistake{"[action]\nstart = [{ quantity = \"air_c\", value = -1 }]\n"
                "[quantity.air_c]\naddress = 1\ntype = \"u16\"\nwrite_function = 6\n",
                14, "'air_c'"},
        Mistake{"[action]\nstart = [{ quantity = \"set_point_c\", value = 1, delay_s = 6 },\n"
                "         { quantity = \"set_point_c\", value = 2, delay_s = 6 }]\n",
                14, "'start'"},
        Mistake{"[[alarm]]\nname = \"a\"\naddresses = [1]\n", 13, "'inactive'"},
        Mistake{"[[alarm]]\nname = \"a\"\naddresses = [1]\nmask = 1\nactive = [1]\n", 13, "'inactive'"},
        Mistake{"[[alarm]]\nname = \"a\"\naddresses = [1]\nactive = []\n", 16, "'active'"},
        Mistake{"[[alarm]]\nname = \"a\"\naddresses = []\nmask = 1\n", 15, "'addresses'"},
        Mistake{"[[alarm]]\nname = \"a\"\naddresses = [1]\nmask = 1\n"
                "[[alarm]]\nname = \"a\"\naddresses = [2]\nmask = 1\n",
                18, "'a'"},
        Mistake{"[quantity.air_c]\naddress = 1\ntype = \"u16\"\nwrite_function = 6\ncommand = true\n", 13, "'air_c'"},
        Mistake{
            "[action]\nstart = [{ quantity = \"go\", value = 1 }]\n"
            "[quantity.go]\naddress = 1\ntype = \"u16\"\nwrite_function = 6\ndecimals_register = 2\ncommand = true\n",
            19, "'decimals_register'"},
        Mistake{"protocol = \"text\"\n", 13, "'protocol'"},
        Mistake{"[write_policy]\nread_back = 1\n", 14, "'write_policy.read_back'"},
        Mistake{"[write_polcy]\n", 13, "'write_polcy'"}));

TEST(RegisterMap, AQuantityGivenTwiceIsRefusedWithItsLine) {
  const std::string message = refusal(chamber_map("[quantity.set_point_c]\naddress = 1\n"));
  EXPECT_TRUE(message.starts_with("m.toml:13: ")) << message;
}

TEST(RegisterMap, TheLinkIsEitherTcpOrRtu) {
  const std::string rest = "[quantity]\n";
  const std::string head = "name = \"r\"\nkind = \"power\"\n[link]\n";
  EXPECT_TRUE(base::mentions(refusal(head + rest), {"m.toml:3: ", "'link'", "'tcp'", "'rtu'"}));
  EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"a:1\"\nrtu = \"/dev/ttyS0\"\n" + rest),
                             {"m.toml:3: ", "'link'", "'tcp'", "'rtu'"}));
  EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"a:1\"\nbaud = 9600\n" + rest), {"m.toml:5: ", "'baud'"}));
  EXPECT_TRUE(
      base::mentions(refusal(head + "rtu = \"/dev/ttyS0\"\nunit = 255\n" + rest), {"m.toml:5: ", "'link.unit'"}));
  EXPECT_TRUE(
      base::mentions(refusal(head + "rtu = \"/dev/ttyS0\"\nbaud = 14400\n" + rest), {"m.toml:5: ", "'link.baud'"}));
  EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"a:1\"\ngap_s = 0.2\nresponse_timeout_s = 0.1\n" + rest),
                             {"m.toml:5: ", "'link.gap_s'", "'response_timeout_s'"}));
  EXPECT_TRUE(base::mentions(refusal(head + "rtu = \"\"\n" + rest), {"m.toml:4: ", "'link.rtu'"}));
  EXPECT_EQ(std::get<TcpAddress>(parse_device_map(head + "tcp = \"host\"\n" + rest, "")->link.address).port, 502);
  for (const char* tcp : {"", ":502", "host:", "host:0", "host:65536", "host:5x"}) {
    EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"" + tcp + "\"\n" + rest),
                               {"m.toml:4: ", "'link.tcp'", fmt::format("\"{}\"", tcp)}));
  }
}

TEST(RegisterMap, OnlyAFixtureHasPositionsAndEachOnce) {
  const std::string rest = "[link]\ntcp = \"a:1\"\n[quantity]\n";
  EXPECT_TRUE(base::mentions(refusal("name = \"f\"\nkind = \"fixture\"\n" + rest), {"m.toml:1: ", "'positions'"}));
  EXPECT_TRUE(base::mentions(refusal("name = \"f\"\nkind = \"fixture\"\npositions = [\"+X\", \"-X\", \"+X\"]\n" + rest),
                             {"m.toml:3: ", "'+X'"}));
  EXPECT_TRUE(base::mentions(refusal("name = \"f\"\nkind = \"fixture\"\npositions = []\n" + rest),
                             {"m.toml:3: ", "'positions'"}));
  EXPECT_TRUE(base::mentions(refusal("name = \"f\"\nkind = \"power\"\npositions = [\"+X\"]\n" + rest),
                             {"m.toml:3: ", "'positions'", "\"fixture\""}));
  EXPECT_TRUE(base::mentions(
      refusal("name = \"f\"\nkind = \"fixture\"\npositions = [\"+X\", \"-X\"]\nazimuths_deg = [5]\n" + rest),
      {"m.toml:4: ", "'azimuths_deg'", "'positions'"}));
}

TEST(RegisterMap, FacesLeanAsTheirCertificateSays) {
  const std::string rest = "[link]\ntcp = \"a:1\"\n[quantity]\n";
  const std::string head = "name = \"f\"\nkind = \"fixture\"\npositions = [\"+X\", \"-X\"]\n" + rest + "[leans_deg]\n";
  const auto map = parse_device_map(head + "\"-X\" = [0.02, -0.01]\n", "m.toml");
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_EQ(map->leans_deg.size(), 1U);
  EXPECT_EQ(map->leans_deg.at("-X"), (std::array<double, 2>{0.02, -0.01}));
  for (const char* wrong : {"\"+Z\" = [0, 0]\n", "\"+X\" = [0.1]\n", "\"+X\" = [0.1, 1.1]\n", "\"+X\" = 0.1\n"}) {
    EXPECT_NE(refusal(head + wrong), "") << wrong;
  }
  EXPECT_NE(refusal("name = \"p\"\nkind = \"power\"\n" + rest + "[leans_deg]\n"), "");
}

TEST(RegisterMap, OutputsOfARelayAreNumbered) {
  const std::string head = "name = \"p\"\nkind = \"power\"\n[link]\ntcp = \"a:1\"\n[quantity]\n";
  EXPECT_EQ(refusal(head + "output_12 = { address = 1, type = \"u16\" }\nstate_1 = { address = 2, type = \"u16\" }\n"),
            "");
  for (const char* name : {"output_", "output_01", "output_x", "outputs_1"}) {
    EXPECT_TRUE(base::mentions(refusal(head + name + " = { address = 1, type = \"u16\" }\n"),
                               {"m.toml:6: ", fmt::format("'{}'", name)}));
  }
}

TEST(RegisterMap, WhatADeviceLacksIsOneMistakeBesideTheOthers) {
  const auto map = parse_device_map(chamber_map("speed = 1\n"), "m.toml", MapUse::device);
  ASSERT_FALSE(map);
  EXPECT_TRUE(base::mentions_in_order(map.error().message, {"2 ", "\nm.toml:2: ", "[quantity.air_c]",
                                                            "[quantity.control_mode]", "\nm.toml:13: ", "'speed'"}));
}

TEST(RegisterMap, WhatAFixtureAndASwitchLackIsToldAsWell) {
  const auto lacking = [](const std::string& head, const std::string& quantities) {
    return lacks_for_a_device("name = \"d\"\n" + head + "[link]\ntcp = \"a:1\"\n[quantity]\n" + quantities);
  };
  const std::string fixture = "kind = \"fixture\"\npositions = [\"+X\"]\n";
  EXPECT_TRUE(base::mentions(
      lacking(fixture, "status = { address = 2, type = \"u16\", codes = { standing = 0, moving = 1 } }\n"),
      {"\"fixture\"", "[quantity.request]", "[quantity.position]", "[quantity.status]", "'fault'", "'codes'"}));
  const std::string power = "kind = \"power\"\n";
  EXPECT_TRUE(base::mentions(lacking(power, "output_2 = { address = 1, type = \"u16\" }\n"),
                             {"\"power\"", "[quantity.output_1]", "[quantity.output_2]", "'write_function'"}));
  EXPECT_TRUE(base::mentions(
      lacking(power, "output_1 = { address = 1, type = \"u16\", write_function = 6, codes = { on = 1, aus = 0 } }\n"),
      {"[quantity.output_1]", "'off'", "'codes'"}));
}

// 1 and 0 would be written where the controller wants 63 and 62.
TEST(RegisterMap, AnOutputOfTheChamberWhoseCodesAreNamedOtherwiseIsAMistake) {
  const auto file = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures/chambers/watlow-f4t.toml";
  std::ifstream in(file);
  const std::string f4t{std::istreambuf_iterator<char>(in), {}};
  const auto with_codes = [&](const std::string& codes) {
    return lacks_for_a_device(f4t + "[quantity.unit_power_2]\naddress = 16596\ntype = \"u16\"\n" +
                              "write_function = 6\ncodes = " + codes + "\n");
  };
  EXPECT_EQ(with_codes("{ off = 62, on = 63 }"), "");
  EXPECT_TRUE(base::mentions(with_codes("{ aus = 62, on = 63 }"), {"[quantity.unit_power_2]", "'off'", "'codes'"}));
}

TEST(RegisterMap, AProtocolThatNobodySpeaksIsRefused) {
  EXPECT_TRUE(base::mentions(refusal("protocol = \"can\"\n" + chamber_map("")),
                             {"m.toml:1: ", "'protocol'", "\"modbus\"", "\"text\""}));
}

TEST(RegisterMap, AFileThatIsMissingIsBadInput) {
  const auto map = read_device_map("/nowhere/map.toml");
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(map.error().where, "/nowhere/map.toml");
}

TEST(RegisterMap, EveryShippedMapMakesItsDevice) {
  const std::filesystem::path procedures = std::filesystem::path(SOAK_TEST_FOLDER).parent_path() / "procedures";
  int count = 0;
  for (const auto& [folder, kind] :
       {std::pair{"chambers", "chamber"}, std::pair{"fixtures", "fixture"}, std::pair{"power", "power"}}) {
    for (const auto& entry : std::filesystem::directory_iterator(procedures / folder)) {
      SCOPED_TRACE(entry.path());
      const auto map = read_device_map(entry.path(), MapUse::device);
      ASSERT_TRUE(map) << map.error().message;
      EXPECT_EQ(map->kind, kind);
      const bool made = map->kind == "chamber"   ? make_chamber(*map).has_value()
                        : map->kind == "fixture" ? make_fixture(*map).has_value()
                                                 : make_unit_power(*map).has_value();
      EXPECT_TRUE(made);
      ++count;
    }
  }
  EXPECT_GE(count, 9);
}

TEST(RegisterMap, TheExampleOfThePageMakesAChamber) {
  const auto map = parse_device_map(test::example_of("## The shortest one"), "docs/register-maps.md");
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->name, "Small chamber");
  EXPECT_TRUE(make_chamber(*map));
}

}  // namespace
}  // namespace soak::hal
