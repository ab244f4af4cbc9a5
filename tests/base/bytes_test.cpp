// SPDX-License-Identifier: Apache-2.0
#include "base/bytes.h"

#include <gtest/gtest.h>

namespace soak::base {
namespace {

TEST(ByteReader, ReadsBackWhatTheWriterWrote) {
  ByteWriter writer;
  writer.write(std::uint8_t{7});
  writer.write(std::int32_t{-2});
  writer.write(1.5F);
  writer.write_text16("°C");
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.read<std::uint8_t>(), 7);
  EXPECT_EQ(reader.read<std::int32_t>(), -2);
  EXPECT_EQ(reader.read<float>(), 1.5F);
  EXPECT_EQ(reader.read<std::uint16_t>(), 3);
  const auto text = reader.take(3);
  ASSERT_TRUE(text);
  EXPECT_EQ(std::string(text->begin(), text->end()), "°C");
  EXPECT_EQ(reader.remaining(), 0U);
}

TEST(ByteWriter, IsLittleEndian) {
  ByteWriter writer;
  writer.write(std::uint32_t{0x01020304});
  EXPECT_EQ(writer.bytes(), (Bytes{4, 3, 2, 1}));
}

TEST(ByteReader, LeavesThePositionWhereAReadPassesTheEnd) {
  const Bytes bytes = {1, 2, 3};
  ByteReader reader(bytes);
  EXPECT_FALSE(reader.read<std::uint32_t>());
  EXPECT_EQ(reader.position(), 0U);
  EXPECT_EQ(reader.read<std::uint16_t>(), 0x0201);
  EXPECT_FALSE(reader.take(2));
  EXPECT_EQ(reader.remaining(), 1U);
}

}  // namespace
}  // namespace soak::base
