// SPDX-License-Identifier: Apache-2.0
#include "base/text.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/random.h"

namespace soak::base {
namespace {

TEST(ParseDouble, TakesWholeTextsOnly) {
  EXPECT_EQ(parse_double("1.5"), 1.5);
  EXPECT_EQ(parse_double("+1e-3"), 1e-3);
  EXPECT_EQ(parse_double("-.5"), -0.5);
  for (const char* bad : {"", " 1", "1 ", "1,5", "1.5x", "nan", "inf", "-inf", "1e999", "0x10", "+-1", "++1", "--1"}) {
    EXPECT_FALSE(parse_double(bad)) << bad;
  }
}

TEST(ParseInt, TakesWholeNumbersOnly) {
  EXPECT_EQ(parse_int("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  for (const char* bad : {"", "1.0", "9223372036854775808", "1e3"}) EXPECT_FALSE(parse_int(bad)) << bad;
}

TEST(Shortest, ReadsBackBitForBit) {
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const auto d = std::bit_cast<double>(random.next());
    if (std::isfinite(d)) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(*parse_double(shortest(d))), std::bit_cast<std::uint64_t>(d));
    }
    const auto f = std::bit_cast<float>(static_cast<std::uint32_t>(random.next()));
    if (std::isfinite(f)) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(*parse_float(shortest(f))), std::bit_cast<std::uint32_t>(f));
    }
  }
  EXPECT_EQ(shortest(0.1F), "0.1");
  EXPECT_EQ(shortest(-0.0), "-0");
}

}  // namespace
}  // namespace soak::base
