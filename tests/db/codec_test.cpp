// SPDX-License-Identifier: Apache-2.0
#include "db/detail/column_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "db/detail/transform.h"
#include "tests/db/support.h"

namespace soak::db::codec {
namespace {

using testing::column_of;
using testing::noise;
using testing::times;

Column round_trip(const Column& column, Effort effort = Effort::smallest) {
  ColumnEncoder encoder;
  ColumnDecoder decoder;
  const auto decoded = decoder.decode(encoder.encode(column, effort), column.type);
  EXPECT_TRUE(decoded) << decoded.error().message;
  return decoded.value_or(Column{});
}

template <class T>
void expect_extremes_survive() {
  using Limits = std::numeric_limits<T>;
  const std::vector<T> extremes = {Limits::max(), Limits::lowest(), T{0}, T{1}, Limits::lowest(), Limits::max()};
  EXPECT_EQ(round_trip(column_of(extremes)), column_of(extremes));
  EXPECT_EQ(round_trip(column_of(std::vector<T>{Limits::lowest()})), column_of(std::vector<T>{Limits::lowest()}));
}

TEST(ColumnCodec, KeepsExtremesOfEveryType) {
  expect_extremes_survive<std::int8_t>();
  expect_extremes_survive<std::uint8_t>();
  expect_extremes_survive<std::int16_t>();
  expect_extremes_survive<std::uint16_t>();
  expect_extremes_survive<std::int32_t>();
  expect_extremes_survive<std::uint32_t>();
  expect_extremes_survive<std::int64_t>();
  expect_extremes_survive<float>();
  expect_extremes_survive<double>();
}

TEST(ColumnCodec, KeepsNanPayloadsNegativeZeroDenormalsAndInfinities) {
  const std::vector<double> doubles = {std::bit_cast<double>(0x7FF8000000001234U),
                                       std::bit_cast<double>(0xFFF0000000000001U),  // signalling
                                       -0.0,
                                       0.0,
                                       std::numeric_limits<double>::denorm_min(),
                                       -std::numeric_limits<double>::denorm_min(),
                                       std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity()};
  EXPECT_EQ(round_trip(column_of(doubles)), column_of(doubles));
  const std::vector<float> floats = {std::bit_cast<float>(0x7FC01234U), std::bit_cast<float>(0xFF800001U), -0.0F, 0.0F,
                                     std::numeric_limits<float>::denorm_min()};
  EXPECT_EQ(round_trip(column_of(floats)), column_of(floats));
}

TEST(ColumnCodec, KeepsNegativeZeroAmongShortDecimals) {
  const std::vector<double> values = {1.25, -0.0, 2.5};
  EXPECT_EQ(round_trip(column_of(values)), column_of(values));
}

/// Short decimals but for row 300, which no sample of a long column holds.
TEST(ColumnCodec, KeepsTheOneNumberThatIsNoShortDecimal) {
  std::vector<double> values(16384);
  for (std::size_t row = 0; row < values.size(); ++row) values[row] = static_cast<double>(row) / 100.0;
  values[300] = std::numbers::pi;
  EXPECT_EQ(round_trip(column_of(values)), column_of(values));
}

/// A column that goes from one kind of data to another is where a sample could mislead.
TEST(ColumnCodec, ASampleChoosesNearlyAsWellAsAllRows) {
  std::vector<std::int32_t> numbers;
  const auto scatter = noise(16384, 8);
  for (std::size_t row = 0; row < scatter.size(); ++row) {
    const double ramp = row < 6000 ? 40.0 * static_cast<double>(row) : 240'000.0;
    numbers.push_back(static_cast<std::int32_t>(std::lround(ramp + 5.0 * static_cast<double>(scatter[row]))));
  }
  double best = std::numeric_limits<double>::infinity();
  for (const Transform transform : kTransforms) {
    std::vector<std::uint32_t> words(numbers.begin(), numbers.end());
    apply(transform, std::span(words), std::uint32_t{0});
    best = std::min(best, entropy_bytes(shuffled(std::span<const std::uint32_t>(words)), words.size()));
  }
  ColumnEncoder encoder;
  EXPECT_LT(static_cast<double>(encoder.encode(column_of(numbers)).data.size()), 1.05 * best);
}

TEST(ColumnCodec, KeepsRowsWithoutValues) {
  const std::vector<std::int32_t> numbers = {5, 0, 7, 0, 0, -9, 0, 0, 11};
  const std::vector<std::uint8_t> present = {1, 0, 1, 1, 0, 1, 0, 0, 1};
  EXPECT_EQ(round_trip(column_of(numbers, present)), column_of(numbers, present));
}

TEST(ColumnCodec, KeepsAColumnWithoutAnyValue) {
  const auto column = column_of(std::vector<double>(100, 0.0), std::vector<std::uint8_t>(100, 0));
  EXPECT_EQ(round_trip(column), column);
}

/// Random bytes of random smoothness: walks, noise, constants, short decimals.
Column random_column(base::Random& random, SampleType type) {
  const auto rows = 1 + static_cast<std::size_t>(random.uniform(0.0, 3000.0));
  Column column{type, base::Bytes(rows * size_of(type)), {}};
  const int kind = static_cast<int>(random.uniform(0.0, 3.0));
  std::uint64_t walk = random.next();
  for (std::size_t row = 0; row < rows; ++row) {
    if (kind == 0) walk = random.next();
    if (kind == 1) walk += random.next() % 16;
    std::memcpy(column.raw.data() + row * size_of(type), &walk, size_of(type));
  }
  if (random.uniform() < 0.5) {
    for (std::size_t row = 0; row < rows; ++row) column.present.push_back(random.uniform() < 0.7 ? 1 : 0);
    column.present.front() = 0;  // with all rows present the bitmap would be dropped
    for (std::size_t row = 0; row < rows; ++row) {
      if (column.present[row] == 0) std::memset(column.raw.data() + row * size_of(type), 0, size_of(type));
    }
  }
  return column;
}

TEST(ColumnCodec, GivesBackRandomColumnsOfEveryTypeBitByBit) {
  base::Random random(42);
  for (int repeat = 0; repeat < 40; ++repeat) {
    for (int type = 0; type <= static_cast<int>(SampleType::f64); ++type) {
      const Column column = random_column(random, static_cast<SampleType>(type));
      ASSERT_EQ(round_trip(column), column) << "type " << type << ", repeat " << repeat;
      ASSERT_EQ(round_trip(column, Effort::quick), column) << "quick, type " << type << ", repeat " << repeat;
    }
  }
}

TEST(ColumnCodec, NoticesEveryFlippedBitOfAChunk) {
  ColumnEncoder encoder;
  const EncodedColumn encoded = encoder.encode(
      column_of(std::vector<std::int16_t>{3, 0, 1, 4, 1, 5}, std::vector<std::uint8_t>{1, 0, 1, 1, 1, 1}));
  const std::uint32_t checksum = checksum_of(encoded, 3, 100);
  for (base::Bytes EncodedColumn::* part : {&EncodedColumn::presence, &EncodedColumn::data}) {
    for (std::size_t bit = 0; bit < (encoded.*part).size() * 8; ++bit) {
      EncodedColumn damaged = encoded;
      (damaged.*part)[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      EXPECT_NE(checksum_of(damaged, 3, 100), checksum);
    }
  }
  EXPECT_NE(checksum_of(encoded, 4, 100), checksum);
  EXPECT_NE(checksum_of(encoded, 3, 101), checksum);
}

TEST(ColumnCodec, RefusesHostileBytesWithoutTheHelpOfAChecksum) {
  ColumnEncoder encoder;
  ColumnDecoder decoder;
  base::Random random(5);
  const EncodedColumn encoded = encoder.encode(column_of(noise(500, 1), std::vector<std::uint8_t>(500, 1)));
  for (int repeat = 0; repeat < 3000; ++repeat) {
    EncodedColumn damaged = encoded;
    damaged.data[random.next() % damaged.data.size()] ^= static_cast<std::uint8_t>(1 + random.next() % 255);
    if (repeat % 3 == 0) damaged.data.resize(random.next() % damaged.data.size());
    const auto decoded = decoder.decode(damaged, SampleType::f32);
    if (decoded) {
      EXPECT_EQ(decoded->rows(), 500U);
    } else {
      EXPECT_EQ(decoded.error().kind, base::ErrorKind::corrupt);
    }
  }
}

TEST(ColumnCodec, RefusesSizesThatDoNotFit) {
  ColumnEncoder encoder;
  ColumnDecoder decoder;
  const EncodedColumn good = encoder.encode(column_of(noise(500, 1)));
  const auto refused = [&](const std::function<void(EncodedColumn&)>& change, SampleType type = SampleType::f32) {
    EncodedColumn changed = good;
    change(changed);
    const auto decoded = decoder.decode(changed, type);
    return !decoded && decoded.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.rows = e.values = std::uint64_t{1} << 60; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.rows = e.values = 501; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.rows = 501; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.values = 499; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.rows = e.values = 0; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.codec = "lzma"; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.codec = "offset+" + e.codec; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.presence = e.data; }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.data.push_back(0); }));
  EXPECT_TRUE(refused([](EncodedColumn& e) { e.data.clear(); }));
  EXPECT_TRUE(refused([](EncodedColumn&) {}, SampleType::f64));
}

TEST(ColumnCodec, DecodesIntoAColumnThatHeldAnother) {
  ColumnEncoder encoder;
  ColumnDecoder decoder;
  const Column gaps = column_of(std::vector<float>{1.5F, 0.0F, -2.5F}, {1, 0, 1});
  const Column full = column_of(std::vector<std::int16_t>{7, -8, 9, 10, 11});
  Column column;
  for (const Column* next : {&gaps, &full, &gaps}) {
    ASSERT_TRUE(decoder.decode(encoder.encode(*next), next->type, column));
    EXPECT_EQ(column, *next);
  }
}

TEST(ColumnCodec, RefusesAFrameThatClaimsMoreThanItsRows) {
  ZstdCompressor compressor;
  ZstdDecompressor decompressor;
  const base::Bytes bomb = compressor.compress(base::Bytes(std::size_t{1} << 26, 0), 0);
  ASSERT_LT(bomb.size(), 100'000U);
  base::Bytes content;
  EXPECT_FALSE(decompressor.decompress(bomb, 2000, content));
  EXPECT_LE(content.size(), 2000U);
}

TEST(Transform, UndoesItselfOnWordsThatWrapAround) {
  base::Random random(9);
  std::vector<std::uint64_t> words(1000);
  for (auto& word : words) word = random.next();
  for (const Transform transform : kTransforms) {
    auto changed = words;
    apply(transform, std::span(changed), words[17]);
    undo(transform, std::span(changed), words[17]);
    EXPECT_EQ(changed, words) << name_of(transform);
  }
}

TEST(Transform, FindsTheDecimalsOfTextNumbers) {
  const std::vector<double> values = {25.125, -3.1, 0.0, 1e6};
  const auto decimals = decimals_of(std::span<const double>(values));
  ASSERT_TRUE(decimals);
  EXPECT_EQ(decimals->digits, 3U);
  EXPECT_EQ(decimals->mantissas, (std::vector<std::uint64_t>{25125, std::uint64_t{0} - 3100, 0, 1'000'000'000}));
  const std::vector<double> irrational = {std::numbers::pi};
  EXPECT_FALSE(decimals_of(std::span<const double>(irrational)));
}

/// Bytes per value of a run of chunks of 16,384 rows.
double bytes_per_value(const Column& column) {
  ColumnEncoder encoder;
  return static_cast<double>(encoder.encode(column).data.size()) / static_cast<double>(column.rows());
}

TEST(ColumnCodec, StoresFloatNoiseNearItsEntropy) {
  // H = h(X) - E[log2 ulp(X)], ulp(x) = 2^(floor(log2 |x|) - 23), h = log2(2 pi e) / 2 for unit variance.
  double mean_exponent = 0.0;
  for (int k = -40; k < 4; ++k) {
    mean_exponent += k * (std::erf(std::exp2(k + 1) / std::sqrt(2.0)) - std::erf(std::exp2(k) / std::sqrt(2.0)));
  }
  const double entropy_bits = 0.5 * std::log2(2.0 * std::numbers::pi * std::numbers::e) - mean_exponent + 23.0;
  const double measured = bytes_per_value(column_of(noise(16384, 3)));
  RecordProperty("bytes_per_value", std::to_string(measured));
  RecordProperty("entropy_bytes", std::to_string(entropy_bits / 8.0));
  EXPECT_LT(measured, 1.03 * entropy_bits / 8.0);
  EXPECT_GT(measured, 0.99 * entropy_bits / 8.0);  // no lossless code can be smaller
}

TEST(ColumnCodec, StoresCountsOfNoiseNearTheirEntropy) {
  std::vector<std::int16_t> counts;
  for (const float value : noise(16384, 4)) counts.push_back(static_cast<std::int16_t>(std::lround(20.0F * value)));
  const double entropy_bits = 0.5 * std::log2(2.0 * std::numbers::pi * std::numbers::e * 400.0);
  const double measured = bytes_per_value(column_of(counts));
  RecordProperty("bytes_per_value", std::to_string(measured));
  EXPECT_LT(measured, 1.05 * entropy_bits / 8.0);
  EXPECT_GT(measured, 0.98 * entropy_bits / 8.0);
}

TEST(ColumnCodec, StoresAnEvenTimeAxisInAlmostNothing) {
  // Products i * 0.01 differ from the decimals i / 100 in the last bit here and there; the quotients do not.
  std::vector<double> decimals;
  for (std::size_t i = 0; i < 16384; ++i) decimals.push_back(static_cast<double>(1'000'000 + i) / 100.0);
  const double products = bytes_per_value(column_of(times(16384, 0.01, 1'000'000)));
  const double quotients = bytes_per_value(column_of(decimals));
  RecordProperty("bytes_per_value", std::to_string(products));
  RecordProperty("bytes_per_decimal", std::to_string(quotients));
  EXPECT_LT(products, 0.1);
  EXPECT_LT(quotients, 0.01);
}

}  // namespace
}  // namespace soak::db::codec
