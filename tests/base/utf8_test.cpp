// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace soak::base {
namespace {

using std::string_view_literals::operator""sv;

TEST(Utf8, TakesTheFirstAndLastCodePointOfEachLength) {
  // RFC 3629, table of section 4.
  EXPECT_TRUE(is_utf8(""));
  EXPECT_TRUE(is_utf8("\x00\x7f"sv));
  EXPECT_TRUE(is_utf8("\xc2\x80\xdf\xbf"));
  EXPECT_TRUE(is_utf8("\xe0\xa0\x80\xed\x9f\xbf\xee\x80\x80\xef\xbf\xbf"));
  EXPECT_TRUE(is_utf8("\xf0\x90\x80\x80\xf4\x8f\xbf\xbf"));
  EXPECT_TRUE(is_utf8("Prüfstand −40 °C"));
}

TEST(Utf8, RefusesEverythingElse) {
  for (const std::string_view text :
       {"\x80"sv, "\xbf"sv, "\xc0\x80"sv, "\xc1\xbf"sv, "\xe0\x9f\xbf"sv, "\xed\xa0\x80"sv, "\xed\xbf\xbf"sv,
        "\xf0\x8f\xbf\xbf"sv, "\xf4\x90\x80\x80"sv, "\xf5\x80\x80\x80"sv, "\xff"sv, "\xc2"sv, "\xe2\x82"sv,
        "\xf0\x9f\x98"sv, "a\xc2z"sv, "caf\xe9"sv}) {
    EXPECT_FALSE(is_utf8(text)) << std::string(text);
  }
}

TEST(Utf8, APlainLineHoldsNothingThatPeopleCannotSee) {
  for (const std::string_view text :
       {""sv, "probe 3"sv, "Prüfstand −40 °C"sv, "عربي"sv, "校正"sv, "\xc2\xa0"sv, "😀"sv}) {
    EXPECT_TRUE(is_plain_line(text)) << text;
  }
  // First and last of each range of the Unicode tables, in UTF-8.
  for (const std::string_view text :
       {"a\0b"sv, "a\x1f"sv, "a\nb"sv, "\t"sv, "\x7f"sv, "\xc2\x80"sv, "\xc2\x85"sv, "\xc2\x9f"sv, "\xe2\x80\xa8"sv,
        "\xe2\x80\xa9"sv, "\xd8\x9c"sv, "\xe2\x80\x8e"sv, "\xe2\x80\x8f"sv, "\xe2\x80\xaa"sv, "a\xe2\x80\xae"sv,
        "\xe2\x81\xa6"sv, "\xe2\x81\xa9"sv, "caf\xe9"sv}) {
    EXPECT_FALSE(is_plain_line(text)) << text;
  }
  for (const std::string_view text : {"\x20\x7e"sv, "\xc2\xa0"sv, "\xe2\x80\x90"sv, "\xe2\x81\xaa"sv}) {
    EXPECT_TRUE(is_plain_line(text)) << "beside the ranges";
  }
}

TEST(Blank, IsTextThatShowsNothing) {
  for (const char* text : {"", " ", "\t\r\n", "\u00a0", "\u2003\u3000", "\u200b", "\ufeff", "\u3164"})
    EXPECT_TRUE(is_blank(text));
  for (const char* text : {"a", " a ", "\u00a0.", "−", "\xa0"}) EXPECT_FALSE(is_blank(text)) << text;
}

}  // namespace
}  // namespace soak::base
