// SPDX-License-Identifier: Apache-2.0
#include "settings/reader.h"
#include "tests/errors.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

namespace soak::settings {
namespace {

constexpr Limits kPercent{0, 100};

/// What finish() says after `ask` has read `text`: "where: message", "" = success.
std::string verdict(std::string_view text, const std::function<void(const Table&)>& ask) {
  const auto reader = Reader::parse(text, "f.toml");
  if (!reader) return reader.error().where + ": " + reader.error().message;
  ask(reader->root());
  const auto status = reader->finish();
  if (status) return "";
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
  return status.error().where + ": " + status.error().message;
}

TEST(SettingsReader, ReadsEveryKindOfValue) {
  const auto ask = [](const Table& root) {
    EXPECT_EQ(root.number("half", kPercent), 0.5);
    EXPECT_EQ(root.number("count", kPercent), 7.0) << "a whole number is a number";
    EXPECT_EQ(root.whole("count", kPercent), 7);
    EXPECT_EQ(root.text("word"), "a b");
    EXPECT_TRUE(root.flag("on"));
    EXPECT_EQ(root.numbers("steps", kPercent), (std::vector<double>{1.0, 2.5}));
    EXPECT_EQ(root.wholes("codes", kPercent), (std::vector<int>{31, 100, 0}));
    EXPECT_EQ(root.texts("labels"), (std::vector<std::string>{"+X", "-X"}));
    EXPECT_EQ(root.choice<int>("kind", {{"soak", 1}, {"ramp", 2}}), 2);
    EXPECT_EQ(root.table("inner")->whole("depth", kPercent), 3);
    const auto rows = root.tables("row");
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_EQ(rows[1].text("name"), "second");
    EXPECT_EQ(rows[0].text("name"), "first");
  };
  EXPECT_EQ(verdict("half = 0.5\ncount = 7\nword = \"a b\"\non = true\nsteps = [1, 2.5]\ncodes = [0x1F, 100, 0]\n"
                    "labels = [\"+X\", \"-X\"]\nkind = \"ramp\"\n[inner]\ndepth = 3\n"
                    "[[row]]\nname = \"first\"\n[[row]]\nname = \"second\"\n",
                    ask),
            "");
}

TEST(SettingsReader, WhatIsAbsentTakesItsFallback) {
  const auto ask = [](const Table& root) {
    EXPECT_EQ(root.number("a", kPercent, 1.5), 1.5);
    EXPECT_EQ(root.whole("b", kPercent, 2), 2);
    EXPECT_EQ(root.text("c", "three"), "three");
    EXPECT_TRUE(root.flag("d", true));
    EXPECT_EQ(root.choice<int>("e", {{"soak", 1}}, 5), 5);
    EXPECT_FALSE(root.optional_number("f", kPercent));
    EXPECT_FALSE(root.optional_whole("g", kPercent));
    EXPECT_TRUE(root.numbers("h", kPercent).empty());
    EXPECT_TRUE(root.wholes("i", kPercent).empty());
    EXPECT_TRUE(root.texts("j").empty());
    EXPECT_FALSE(root.table("k"));
    EXPECT_TRUE(root.tables("l").empty());
    EXPECT_FALSE(root.has("a"));
  };
  EXPECT_EQ(verdict("", ask), "");
}

TEST(SettingsReader, AMissingKeyIsNamedWithItsTableAndTheTablesLine) {
  const auto ask = [](const Table& root) {
    const auto inner = root.table("inner");
    ASSERT_TRUE(inner);
    EXPECT_EQ(inner->whole("depth", kPercent), 0);
  };
  EXPECT_TRUE(base::mentions(verdict("\n\n[inner]\n", ask), {"f.toml:3: ", "'inner.depth'"}));
}

struct Wrong {
  const char* value;
  std::function<void(const Table&)> ask;
  const char* right;  ///< what the refusal says would be right
};

class WrongValue : public testing::TestWithParam<Wrong> {};

TEST_P(WrongValue, IsRefusedWithItsLine) {
  const std::string text = std::string("# a comment\nkey = ") + GetParam().value + "\n";
  EXPECT_TRUE(base::mentions(verdict(text, GetParam().ask), {"f.toml:2: ", "'key'", GetParam().right}));
}

void ask_number(const Table& root) { EXPECT_EQ(root.number("key", kPercent), 0.0); }
void ask_whole(const Table& root) { EXPECT_EQ(root.whole("key", kPercent, 9), 9); }
void ask_text(const Table& root) { EXPECT_EQ(root.text("key"), ""); }
void ask_flag(const Table& root) { EXPECT_FALSE(root.flag("key")); }
void ask_numbers(const Table& root) { static_cast<void>(root.numbers("key", kPercent)); }
void ask_wholes(const Table& root) { static_cast<void>(root.wholes("key", kPercent)); }
void ask_texts(const Table& root) { static_cast<void>(root.texts("key")); }
void ask_choice(const Table& root) { EXPECT_EQ(root.choice<int>("key", {{"soak", 1}, {"ramp", 2}}), 0); }
void ask_table(const Table& root) { EXPECT_FALSE(root.table("key")); }
void ask_tables(const Table& root) { EXPECT_TRUE(root.tables("key").empty()); }

INSTANTIATE_TEST_SUITE_P(
    All, WrongValue,
    testing::Values(Wrong{"\"7\"", ask_number, "0 to 100"}, Wrong{"-0.001", ask_number, "0 to 100"},
                    Wrong{"100.001", ask_number, "0 to 100"}, Wrong{"nan", ask_number, "0 to 100"},
                    Wrong{"inf", ask_number, "0 to 100"}, Wrong{"true", ask_number, "0 to 100"},
                    Wrong{"7.0", ask_whole, "0 to 100"}, Wrong{"101", ask_whole, "0 to 100"},
                    Wrong{"9223372036854775807", ask_whole, "0 to 100"}, Wrong{"\"7\"", ask_whole, "0 to 100"},
                    Wrong{"7", ask_text, "quotes"}, Wrong{"1", ask_flag, "true or false"},
                    Wrong{"5", ask_numbers, "list"}, Wrong{"[5, 101]", ask_numbers, "list"},
                    Wrong{"[5, 6.5]", ask_wholes, "list"}, Wrong{"[\"a\", 1]", ask_texts, "list"},
                    Wrong{"\"walk\"", ask_choice, "\"soak\", \"ramp\""}, Wrong{"1", ask_choice, "\"soak\", \"ramp\""},
                    Wrong{"1", ask_table, "table"}, Wrong{"{ a = 1 }", ask_tables, "[[key]]"},
                    Wrong{"[1]", ask_tables, "[[key]]"}));

TEST(SettingsReader, BothEndsOfALimitAreAllowed) {
  const auto ask = [](const Table& root) {
    EXPECT_EQ(root.number("low", kPercent), 0.0);
    EXPECT_EQ(root.whole("high", kPercent), 100);
  };
  EXPECT_EQ(verdict("low = 0.0\nhigh = 100\n", ask), "");
}

TEST(SettingsReader, AKeyThatNobodyAskedForIsAMistakeAtAnyDepth) {
  const auto ask = [](const Table& root) {
    static_cast<void>(root.table("inner")->has("depht"));
    for (const Table& row : root.tables("row")) static_cast<void>(row.text("name"));
  };
  EXPECT_TRUE(base::mentions_in_order(
      verdict("[inner]\ndepht = 3\n[[row]]\nname = \"a\"\n[[row]]\nname = \"b\"\nnane = \"c\"\n[stray]\nx = 1\n", ask),
      {"f.toml: 3 ", "\nf.toml:2: ", "'depht'", "\nf.toml:7: ", "'nane'", "\nf.toml:8: ", "'stray'"}));
}

TEST(SettingsReader, AllMistakesAreToldAtOnceInTheOrderOfLines) {
  const auto ask = [](const Table& root) {
    static_cast<void>(root.table("inner")->flag("on"));
    static_cast<void>(root.whole("count", kPercent));
    static_cast<void>(root.text("word"));
    static_cast<void>(root.whole("good", kPercent));
    root.refuse("word", "'word' is empty");  // follows from its type: not told
    root.refuse("good", "'good' occurs elsewhere");
  };
  EXPECT_TRUE(base::mentions_in_order(
      verdict("word = 5\ngood = 1\ncount = 1000\n[inner]\non = \"yes\"\n", ask),
      {"f.toml: 4 ", "\nf.toml:1: 'word'", "\nf.toml:2: 'good'", "\nf.toml:3: 'count'", "\nf.toml:5: 'inner.on'"}));
}

TEST(SettingsReader, InAnAbsentSectionEveryKeyHasItsFallbackAndNoneIsMissing) {
  const auto ask = [](const Table& root) {
    const Table section = root.section("power");
    EXPECT_EQ(section.number("off_s", kPercent, 3.0), 3.0);
    EXPECT_EQ(section.number("warm_up_s", kPercent), 0.0);
    EXPECT_TRUE(section.keys().empty());
    EXPECT_FALSE(section.table("inner"));
  };
  EXPECT_EQ(verdict("", ask), "");
}

TEST(SettingsReader, ARequiredSectionThatIsAbsentIsOneMistake) {
  const auto ask = [](const Table& root) {
    for (int time = 0; time < 2; ++time) {
      const Table section = root.section("power", kRequired);
      static_cast<void>(section.number("off_s", kPercent));
      section.refuse("off_s", "follows from what is missing");
    }
  };
  EXPECT_TRUE(base::mentions(verdict("# nothing\n", ask), {"f.toml:1: ", "'power'"}));
}

TEST(SettingsReader, TellsWhatStandsUnderAKey) {
  const auto ask = [](const Table& root) {
    const std::pair<const char*, Kind> expected[] = {{"a", Kind::text},  {"b", Kind::whole}, {"c", Kind::real},
                                                     {"d", Kind::flag},  {"e", Kind::list},  {"f", Kind::table},
                                                     {"g", Kind::other}, {"h", Kind::absent}};
    for (const auto& [key, kind] : expected) {
      EXPECT_EQ(root.kind(key), kind) << key;
      root.refuse(key, key);
    }
  };
  EXPECT_NE(verdict("a = \"x\"\nb = 1\nc = 1.5\nd = true\ne = [1]\nf = {}\ng = 2026-11-23\n", ask), "");
}

TEST(SettingsReader, ReadsSeedsBeyondTheRangeOfInt) {
  const auto ask = [](const Table& root) { EXPECT_EQ(root.large_whole("seed", {0, 9e18}), 5'000'000'000); };
  EXPECT_EQ(verdict("seed = 5000000000\n", ask), "");
}

TEST(SettingsReader, SaysWhichKeysAreKnownWhereTheFormatListsThem) {
  const auto ask = [](const Table& root) {
    root.allow_only({"up", "rate"}, " (in quotes)");
    static_cast<void>(root.whole("up", kPercent));
  };
  EXPECT_TRUE(base::mentions(verdict("up = 1\ndown = 2\n", ask), {"f.toml:2: ", "'down'", "up, rate (in quotes)"}));
}

TEST(SettingsReader, TablesOfAnArrayAreNumberedInMessages) {
  const auto ask = [](const Table& root) {
    for (const Table& row : root.tables("row")) static_cast<void>(row.whole("n", kPercent));
  };
  EXPECT_TRUE(base::mentions(verdict("[[row]]\nn = 1\n\n[[row]]\nn = -1\n", ask), {"f.toml:5: ", "'row[2].n'"}));
}

TEST(SettingsReader, KeysComeInTheOrderOfTheTextAndAreNotReadByThat) {
  const auto ask = [](const Table& root) {
    EXPECT_EQ(root.keys(), (std::vector<std::string>{"zeta", "alpha", "mid"}));
  };
  EXPECT_TRUE(base::mentions_in_order(verdict("zeta = 1\nalpha = 2\nmid = 3\n", ask),
                                      {"f.toml:1: ", "'zeta'", "f.toml:2: ", "'alpha'", "f.toml:3: ", "'mid'"}));
}

TEST(SettingsReader, ASyntaxErrorAndAKeyGivenTwiceAreToldWithTheirLine) {
  for (const char* text : {"a = 1\nb = = 2\n", "a = 1\na = 2\n", "[t]\n[t]\n", "a = 1\nb = \"open\n"}) {
    const auto reader = Reader::parse(text, "f.toml");
    ASSERT_FALSE(reader) << text;
    EXPECT_EQ(reader.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(reader.error().where, "f.toml:2") << text << reader.error().message;
    EXPECT_FALSE(reader.error().message.empty());
  }
}

TEST(SettingsReader, WindowsLineEndsAndAByteOrderMarkChangeNothing) {
  const auto ask = [](const Table& root) { static_cast<void>(root.whole("b", kPercent)); };
  EXPECT_TRUE(base::mentions(verdict("\xEF\xBB\xBF# comment\r\nb = 500\r\n", ask), {"f.toml:2: ", "'b'"}));
}

TEST(SettingsText, AFileThatIsNoneIsBadInputThatNamesIt) {
  for (const char* file : {"/nowhere/at/all.toml", "/tmp"}) {
    const auto text = read_text(file);
    ASSERT_FALSE(text) << file;
    EXPECT_EQ(text.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(text.error().where, file);
  }
  EXPECT_EQ(read_text("/dev/null").value_or("not read"), "");
}

TEST(SettingsText, OneOfMoreThan32KiBIsRefused) {
  const auto of_size = [](std::size_t size) { return "a = 1\n#" + std::string(size - 7, 'x'); };
  EXPECT_TRUE(Reader::parse(of_size(32768), "f.toml"));
  const auto refused = Reader::parse(of_size(32769), "f.toml");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(refused.error().where, "f.toml");
  EXPECT_TRUE(names(refused.error(), {"32768"}));
}

TEST(SettingsText, OfAFileWithoutEndOnlyWhatIsNeededToRefuseItIsRead) {
  const auto text = read_text("/dev/zero");
  ASSERT_TRUE(text);
  EXPECT_EQ(text->size(), 32769U);
  EXPECT_FALSE(Reader::parse(*text, "/dev/zero"));
}

}  // namespace
}  // namespace soak::settings
