// SPDX-License-Identifier: Apache-2.0
#include "base/utf8.h"

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

}  // namespace
}  // namespace soak::base
