// SPDX-License-Identifier: Apache-2.0
// What every decoder of a unit's stream must do; the formats themselves are in xbus_, vectornav_ and
// ahrs400_decoder_test.cpp.
#include <gtest/gtest.h>

#include "base/random.h"
#include "tests/hal/decoder_wires.h"

namespace soak::hal::imu::test {
namespace {

template <class Wire>
class Decoder : public ::testing::Test {};

class WireNames {
 public:
  template <class Wire>
  static std::string GetName(int /*index*/) {
    if (std::is_same_v<Wire, XbusWire>) return "Xbus";
    return std::is_same_v<Wire, VectorNavWire> ? "VectorNav" : "Ahrs400";
  }
};

using Wires = ::testing::Types<XbusWire, VectorNavWire, Ahrs400Wire>;
TYPED_TEST_SUITE(Decoder, Wires, WireNames);

TYPED_TEST(Decoder, EverySplitOfTheStreamGivesTheSameMessages) {
  const Bytes stream = TypeParam::difficult_stream();
  const auto expected = decode<TypeParam>(stream);
  ASSERT_EQ(expected.size(), TypeParam::kDifficultMessages);
  for (std::size_t split = 0; split <= stream.size(); ++split) {
    typename TypeParam::Decoder decoder;
    std::vector<typename TypeParam::Message> messages;
    decoder.append(std::span(stream).first(split));
    drain<TypeParam>(decoder, messages);
    decoder.append(std::span(stream).subspan(split));
    drain<TypeParam>(decoder, messages);
    ASSERT_EQ(messages, expected) << "split at " << split;
  }
}

TYPED_TEST(Decoder, ByteByByteGivesTheSameMessagesAndGarbage) {
  const Bytes stream = TypeParam::difficult_stream();
  typename TypeParam::Decoder at_once;
  at_once.append(stream);
  std::vector<typename TypeParam::Message> expected;
  drain<TypeParam>(at_once, expected);
  typename TypeParam::Decoder decoder;
  std::vector<typename TypeParam::Message> messages;
  for (const std::uint8_t byte : stream) {
    decoder.append(std::span(&byte, 1));
    drain<TypeParam>(decoder, messages);
  }
  EXPECT_EQ(messages, expected);
  EXPECT_EQ(decoder.garbage_bytes(), at_once.garbage_bytes());
  EXPECT_GT(decoder.garbage_bytes(), 0U);
}

// Every other byte of the noise is one that means something in the protocol.
TYPED_TEST(Decoder, AccountsForEveryRandomByteInBoundedMemory) {
  base::Random random(20261121);
  typename TypeParam::Decoder decoder;
  std::uint64_t fed = 0;
  std::uint64_t framed = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = round % 2 == 0 ? TypeParam::difficult_stream() : Bytes{};
    for (std::uint64_t i = random.next() % 400; i > 0; --i) {
      const std::uint64_t word = random.next();
      bytes.push_back(word % 2 == 0 ? TypeParam::kSpecialBytes[(word >> 8U) % TypeParam::kSpecialBytes.size()]
                                    : static_cast<std::uint8_t>(word >> 8U));
    }
    decoder.append(bytes);
    fed += bytes.size();
    while (const auto message = decoder.next()) framed += TypeParam::frame_size(*message);
    ASSERT_LE(decoder.pending_bytes(), TypeParam::kMostPending);
    ASSERT_EQ(decoder.garbage_bytes() + framed + decoder.pending_bytes(), fed);
  }
  EXPECT_GT(framed, fed / 10);
  EXPECT_GT(decoder.garbage_bytes(), fed / 10);
}

}  // namespace
}  // namespace soak::hal::imu::test
