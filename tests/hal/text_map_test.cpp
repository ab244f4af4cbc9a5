// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/device_map.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "hal/devices/chamber.h"
#include "hal/devices/detail/text_codec.h"
#include "hal/devices/unit_power.h"
#include "tests/errors.h"
#include "tests/hal/map_samples.h"

namespace soak::hal {
namespace {

/// A map without mistakes, of 11 lines; `more` begins in line 12.
std::string text_map(const std::string& more) {
  return "name = \"rig\"\n"
         "kind = \"chamber\"\n"
         "protocol = \"text\"\n"
         "[link]\n"
         "tcp = \"chamber.lab:10001\"\n"
         "[quantity.set_point_c]\n"
         "ask = \"TEMP?\"\n"
         "field = 2\n"
         "write = \"TEMP, S{}\"\n"
         "min = -70\n"
         "max = 180\n" +
         more;
}

using test::example_of;
using test::Mistake;
using test::refusal;

TEST(TextMap, ReadsEveryKey) {
  const auto map = parse_device_map(R"(
name = "full"
kind = "chamber"
protocol = "text"
refusals = ["NA:", "ERR"]
[link]
serial = "/dev/ttyUSB0"
baud = 19200
prefix = "1,"
line_end = "\r"
response_timeout_s = 2
gap_s = 0.1
poll_s = 5
[quantity.air_c]
ask = "TEMP?"
fields = 4
[quantity.set_point_c]
ask = "TEMP?"
field = 2
write = "TEMP, S{}"
decimals = 2
min = -40
max = 150
[quantity.control_mode]
ask = "MODE?"
words = { off = "STANDBY", auto = "CONSTANT" }
write = "MODE,{}"
[[probe]]
name = "type"
ask = "TYPE?"
field = 3
expected = ["SCP220"]
otherwise = "another one"
[action]
start = [{ quantity = "set_point_c", value = 20, delay_s = 2 }, { quantity = "control_mode", code = "auto" }]
[[alarm]]
name = "alarm"
ask = "ALARM?"
inactive = ["0"]
outputs_off = true
[write_policy]
only_on_change = false
read_back = false
)",
                                    "full.toml");
  ASSERT_TRUE(map) << map.error().message;
  test::expect_common_keys(*map);
  EXPECT_EQ(map->refusals, (std::vector<std::string>{"NA:", "ERR"}));
  EXPECT_EQ(map->link.prefix, "1,");
  EXPECT_EQ(map->link.line_end, "\r");
  EXPECT_EQ(map->link.response_timeout_s, 2.0);
  EXPECT_EQ(map->link.gap_s, 0.1);
  EXPECT_EQ(map->link.poll_s, 5.0);
  EXPECT_EQ(map->quantities.at("air_c").text.from.fields, 4);
  EXPECT_EQ(map->quantities.at("air_c").text.from.field, 1);
  const Quantity& set_point = map->quantities.at("set_point_c");
  EXPECT_FALSE(set_point.text.from.fields);
  EXPECT_EQ(set_point.text.from.field, 2);
  EXPECT_EQ(set_point.text.decimals, 2);
  EXPECT_EQ(map->quantities.at("control_mode").codes.at("auto"), 1);
  EXPECT_EQ(map->probes.at(0).text.from.field, 3);
  EXPECT_EQ(map->probes.at(0).text.expected, (std::vector<std::string>{"SCP220"}));
  EXPECT_EQ(map->actions.at("start").at(0).delay_s, 2.0);
  EXPECT_EQ(map->actions.at("start").at(1).value, 1.0) << "the number of the code";
  EXPECT_EQ(map->alarms.at(0).text.inactive, (std::vector<std::string>{"0"}));
  EXPECT_TRUE(map->alarms.at(0).outputs_off);
}

TEST(TextMap, WhatIsAbsentHasItsDefault) {
  const auto map = parse_device_map(text_map(""), "m.toml");
  ASSERT_TRUE(map) << map.error().message;
  test::expect_common_defaults(*map);
  EXPECT_EQ(map->link.line_end, "\r\n");
  EXPECT_EQ(map->link.response_timeout_s, 3.0);
  EXPECT_EQ(map->link.gap_s, 0.0);
  EXPECT_EQ(map->quantities.at("set_point_c").text.decimals, 1);
}

class TextMapMistake : public testing::TestWithParam<Mistake> {};

TEST_P(TextMapMistake, IsRefusedWithItsLine) { EXPECT_TRUE(test::is_refused_with_its_line(text_map(""), GetParam())); }

INSTANTIATE_TEST_SUITE_P(
    All, TextMapMistake,
    testing::Values(Mistake{"decimals = 7\n", 12, "'quantity.set_point_c.decimals'"},
                    Mistake{"address = 7\n", 12, "'address'"},
                    Mistake{"[quantity.air_x]\nask = \"A?\"\n", 12, "'air_x'"},
                    Mistake{"[quantity.air_c]\nask = \"\"\n", 13, "'ask'"},
                    Mistake{"[quantity.air_c]\nask = \"A\\n\"\n", 13, "'ask'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\nfields = 2\nfield = 3\n", 15, "'field'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\nmax = 3\n", 14, "'max'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\nwidth = 3\n", 14, "'width'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\naccepted = [\"0\"]\n", 14, "'accepted'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\ncharacter = 2\nfields = 2\n", 14, "'character'"},
                    Mistake{"[quantity.air_c]\nask = \"A?\"\ncharacter = 9\nlength = 8\n", 14, "'character'"},
                    Mistake{"[quantity.ramp_rate]\ncommand = true\n", 12, "'ramp_rate'"},
                    Mistake{"accepted = [\"0\"]\n[confirm]\nask = \"E?\"\naccepted = [\"0\"]\n", 13, "'set_point_c'"},
                    Mistake{"[quantity.ramp_rate]\nask = \"A?\"\nwrite = \"A\"\n", 14, "'write'"},
                    Mistake{"[quantity.ramp_rate]\nask = \"A?\"\nwrite = \"A{}\"\nmin = 2\nmax = 1\n", 15, "'min'"},
                    Mistake{"[quantity.control_mode]\nask = \"A?\"\nwords = {}\n", 14, "'words'"},
                    Mistake{"[quantity.control_mode]\nask = \"A?\"\nwords = { a = \"X\", b = \"X\" }\n", 14, "'X'"},
                    Mistake{"[quantity.control_mode]\nask = \"A?\"\nwords = { a = \"X\" }\nwrite = \"A{}\"\nmax = 1\n",
                            16, "'max'"},
                    Mistake{"[[probe]]\nname = \"p\"\nask = \"A?\"\nexpected = []\notherwise = \"o\"\n", 15,
                            "'expected'"},
                    Mistake{"[[alarm]]\nname = \"a\"\nask = \"A?\"\n", 12, "'alarm[1].inactive'"},
                    Mistake{"[[alarm]]\nname = \"a\"\nask = \"A?\"\ninactive = [\"0\"]\n"
                            "[[alarm]]\nname = \"a\"\nask = \"A?\"\ninactive = [\"0\"]\n",
                            17, "'a'"},
                    Mistake{"[action]\nstart = [{ quantity = \"set_point_c\", value = 181 }]\n", 13, "'set_point_c'"},
                    Mistake{"[action]\nstart = [{ quantity = \"air_c\", value = 1 }]\n[quantity.air_c]\nask = \"A?\"\n",
                            13, "'air_c'"}));

TEST(TextMap, TheLinkIsEitherTcpOrSerial) {
  const std::string head = "name = \"r\"\nkind = \"chamber\"\nprotocol = \"text\"\n[link]\n";
  const std::string rest = "[quantity]\n";
  EXPECT_TRUE(base::mentions(refusal(head + rest), {"m.toml:4: ", "'link'", "'tcp'", "'serial'"}));
  EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"host\"\n" + rest),
                             {"m.toml:5: ", "'link.tcp'", "\"host:port\"", "\"host\""}));
  EXPECT_TRUE(base::mentions(refusal(head + "tcp = \"h:1\"\nbaud = 9600\n" + rest), {"m.toml:6: ", "'baud'"}));
  EXPECT_TRUE(
      base::mentions(refusal(head + "serial = \"/dev/x\"\nbaud = 14400\n" + rest), {"m.toml:6: ", "'link.baud'"}));
  EXPECT_TRUE(
      base::mentions(refusal(head + "tcp = \"h:1\"\nline_end = \";\"\n" + rest), {"m.toml:6: ", "'link.line_end'"}));
}

TEST(TextMap, ASeparatorIsOneCharacterOfAsciiOrLatin1) {
  const auto separated = [](const std::string& separator) {
    return refusal("name = \"r\"\nkind = \"chamber\"\nprotocol = \"text\"\n[link]\ntcp = \"h:1\"\nseparator = \"" +
                   separator + "\"\n[quantity.air_c]\nask = \"1¶1\"\n");
  };
  for (const char* good : {",", " ", ";", "¶", "¡", "ÿ"}) EXPECT_EQ(separated(good), "") << good;
  for (const char* bad : {"", ",,", "\\t", "€", "\\u0080", "\\u00A0"}) {
    EXPECT_TRUE(base::mentions(separated(bad), {"m.toml:6: ", "'link.separator'"})) << bad;
  }
}

TEST(TextMap, WhatAChamberNeedsIsToldAtOnce) {
  const auto map = parse_device_map(text_map(""), "m.toml", MapUse::device);
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().where, "m.toml:2");
  EXPECT_TRUE(names(map.error(), {"[quantity.air_c]", "[quantity.control_mode]"}));
  EXPECT_FALSE(make_chamber(parse_device_map(text_map(""), "m.toml").value()));
}

TEST(TextMap, AnEmptyRefusalWouldRefuseEverything) {
  EXPECT_TRUE(base::mentions(refusal("refusals = [\"\"]\n" + text_map("")), {"m.toml:1: "}));
}

TextPlace number(int field, std::optional<int> fields = {}) {
  TextPlace place;
  place.from = {"TEMP?", fields, field};
  return place;
}

TEST(TextAnswer, ANumberIsTheWholeFieldAndFinite) {
  EXPECT_EQ(decode_answer(number(1, 4), "23.2,25.0,150.0,-60.0").value_or(0.0), 23.2);
  EXPECT_EQ(decode_answer(number(4, 4), " 23.2 , 25.0,150.0, -60.0 ").value_or(0.0), -60.0);
  EXPECT_EQ(decode_answer(number(1), "+23.2").value_or(0.0), 23.2);
  for (const char* bad : {"", "OFF", "nan", "inf", "1e999", "23.2C", "0x10", "++1", "+-1", "2 3"}) {
    EXPECT_FALSE(decode_answer(number(1), bad)) << bad;
  }
}

TEST(TextAnswer, ANumberOfFieldsThatIsStatedIsDemanded) {
  EXPECT_FALSE(decode_answer(number(1, 4), "23.2"));
  EXPECT_FALSE(decode_answer(number(1, 1), "23.2,25.0"));
  EXPECT_FALSE(decode_answer(number(2), "23.2"));
  EXPECT_EQ(decode_answer(number(2), "1,2,3").value_or(0.0), 2.0);
}

TEST(TextAnswer, FieldsHaveTheSeparatorOfTheMap) {
  TextPlace place = number(2, 2);
  place.from.separator = "¶";
  EXPECT_EQ(decode_answer(place, "1¶23.4").value_or(0.0), 23.4);
  EXPECT_FALSE(decode_answer(place, "1,23.4"));
  place = number(3, 3);
  place.from.separator = " ";
  EXPECT_EQ(decode_answer(place, " A0 023.4   -12.5 ").value_or(0.0), -12.5);
}

TEST(TextAnswer, ALengthIsDemandedAndOneCharacterCanBeTheValue) {
  TextPlace place = number(1);
  place.from.length = 4;
  EXPECT_EQ(decode_answer(place, "23.4").value_or(0.0), 23.4);
  for (const char* bad : {"23.", "023.4", ""}) EXPECT_FALSE(decode_answer(place, bad)) << bad;
  place.from.character = 2;
  place.words = {"0", "1"};
  EXPECT_EQ(decode_answer(place, "S101").value_or(-1.0), 1.0);
  EXPECT_FALSE(decode_answer(place, "S201"));
  place.from.length.reset();
  EXPECT_FALSE(decode_answer(place, "S"));
}

TEST(TextAnswer, NumbersAreFilledUpWithZeros) {
  TextPlace place = number(1);
  place.width = 5;
  EXPECT_EQ(spell(place, 25.0).value(), "025.0");
  EXPECT_EQ(spell(place, -5.0).value(), "-05.0");
  EXPECT_EQ(spell(place, 125.04).value(), "125.0");
}

TEST(TextAnswer, AWordThatTheMapDoesNotKnowIsNoValue) {
  TextPlace mode = number(1);
  mode.words = {"STANDBY", "CONSTANT"};
  EXPECT_EQ(decode_answer(mode, "CONSTANT").value_or(-1.0), 1.0);
  for (const char* bad : {"", "constant", "RUN", "CONSTANT1"}) EXPECT_FALSE(decode_answer(mode, bad)) << bad;
  EXPECT_EQ(spell(mode, 0.0).value_or(""), "STANDBY");
  for (const double bad : {-1.0, 0.5, 2.0, 1e300}) EXPECT_FALSE(spell(mode, bad)) << bad;
}

TEST(TextAnswer, ValuesAreSpelledWithTheDecimalsOfTheMap) {
  TextPlace set_point = number(2);
  set_point.write = "TEMP, S{}";
  EXPECT_EQ(write_command(set_point, spell(set_point, -40.0).value()), "TEMP, S-40.0");
  set_point.decimals = 0;
  EXPECT_EQ(write_command(set_point, spell(set_point, 25.4).value()), "TEMP, S25");
}

/// A map of a supply, of 8 lines; `more` begins in line 9.
std::string power_map(const std::string& more) {
  return "name = \"supply\"\n"
         "kind = \"power\"\n"
         "protocol = \"text\"\n"
         "[link]\n"
         "tcp = \"supply.lab:5025\"\n"
         "[quantity.output_1]\n"
         "ask = \"OUTP?\"\n"
         "write = \"OUTP {}\"\n" +
         more;
}

TEST(TextMap, AMapOfASupplyNamesItsOutputsByNumber) {
  const auto map = parse_device_map(power_map("[quantity.measured_v_12]\nask = \"MEAS:VOLT? 12\"\n"
                                              "[confirm]\nask = \"SYST:ERR?\"\naccepted = [\"0,\"]\n"),
                                    "m.toml", MapUse::device);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->kind, "power");
  EXPECT_EQ(map->confirm->ask, "SYST:ERR?");
  EXPECT_EQ(map->confirm->accepted, (std::vector<std::string>{"0,"}));
  for (const char* name : {"measured_v_", "measured_v_0", "measured_v_1a", "air_c"}) {
    EXPECT_NE(refusal(power_map(std::string("[quantity.") + name + "]\nask = \"X?\"\n")), "") << name;
  }
  EXPECT_NE(refusal(text_map("[quantity.output_1]\nask = \"X?\"\n")), "") << "no chamber has that";
}

TEST(TextMap, ExplainsWhatASupplyLacks) {
  const auto lacking = [](const std::string& more) { return test::lacks_for_a_device(power_map(more)); };
  EXPECT_TRUE(base::mentions(lacking("[quantity.set_v_1]\nask = \"VOLT?\"\n"), {"[quantity.set_v_1]", "'write'"}));
  EXPECT_TRUE(base::mentions(lacking("words = { on = \"ON\", away = \"OFF\" }\n"),
                             {"[quantity.output_1]", "'off'", "'words'"}));
}

TEST(TextMap, AConfirmationAcceptsSomethingInParticular) {
  EXPECT_TRUE(
      base::mentions(refusal(text_map("[confirm]\nask = \"ERR?\"\naccepted = []\n")), {"m.toml:14: ", "'accepted'"}));
  EXPECT_TRUE(base::mentions(refusal(text_map("[confirm]\nask = \"ERR?\"\naccepted = [\"\"]\n")), {"m.toml:14: "}));
}

TEST(TextMap, TheExamplesOfThePageMakeAChamberAndASupply) {
  const auto chamber =
      parse_device_map(example_of("## Chambers that speak text"), "docs/register-maps.md", MapUse::device);
  ASSERT_TRUE(chamber) << chamber.error().message;
  EXPECT_TRUE(make_chamber(*chamber));
  const auto supply =
      parse_device_map(example_of("## Supplies that speak text"), "docs/register-maps.md", MapUse::device);
  ASSERT_TRUE(supply) << supply.error().message;
  EXPECT_TRUE(make_unit_power(*supply));
}

}  // namespace
}  // namespace soak::hal
