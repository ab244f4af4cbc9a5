// SPDX-License-Identifier: Apache-2.0
// The pyramid of a run file against brute force over its samples.
#include <bit>

#include <algorithm>
#include <cmath>
#include <limits>

#include "db/run/run_file.h"
#include "tests/db/support.h"

namespace soak::db {
namespace {

using testing::channel;
using testing::column_of;
using testing::noise;
using testing::noise_stream;
using testing::run_info;
using testing::TempFolder;
using testing::times;

struct Samples {
  std::vector<double> t_s;
  std::vector<double> values;
};

/// The bin that the samples of rows [first, end) make, by the definition.
PyramidBin brute_force(const Samples& samples, std::size_t first, std::size_t end) {
  PyramidBin bin;
  bin.t_first_s = samples.t_s[first];
  bin.t_last_s = samples.t_s[end - 1];
  bin.minimum = std::numeric_limits<double>::infinity();
  bin.maximum = -bin.minimum;
  for (std::size_t row = first; row < end; ++row) {
    if (!std::isfinite(samples.values[row])) continue;
    ++bin.count;
    bin.mean += samples.values[row];
    bin.minimum = std::min(bin.minimum, samples.values[row]);
    bin.maximum = std::max(bin.maximum, samples.values[row]);
  }
  bin.mean /= static_cast<double>(bin.count);
  return bin;
}

/// Checks that the bins follow each other without gap or overlap and each equals brute force over its rows.
void expect_bins_cover(const std::vector<PyramidBin>& bins, const Samples& samples, double from_s, double to_s) {
  ASSERT_FALSE(bins.empty());
  std::size_t next = static_cast<std::size_t>(
      std::lower_bound(samples.t_s.begin(), samples.t_s.end(), bins.front().t_first_s) - samples.t_s.begin());
  for (const PyramidBin& bin : bins) {
    const auto end = static_cast<std::size_t>(std::upper_bound(samples.t_s.begin(), samples.t_s.end(), bin.t_last_s) -
                                              samples.t_s.begin());
    ASSERT_LT(next, end);
    const PyramidBin expected = brute_force(samples, next, end);
    ASSERT_EQ(bin.t_first_s, expected.t_first_s);
    ASSERT_EQ(bin.count, expected.count);
    ASSERT_EQ(bin.minimum, expected.minimum);
    ASSERT_EQ(bin.maximum, expected.maximum);
    // n additions of numbers up to 5 in double against long double: n · 5 · 2^-53 is under 1e-9 up to a million rows.
    ASSERT_NEAR(bin.mean, expected.mean, 1e-9);
    next = end;
  }
  const auto inside = std::lower_bound(samples.t_s.begin(), samples.t_s.end(), from_s);
  EXPECT_LE(bins.front().t_first_s, inside == samples.t_s.end() ? from_s : *inside);
  const auto after = std::upper_bound(samples.t_s.begin(), samples.t_s.end(), to_s);
  EXPECT_GE(bins.back().t_last_s, *(after - 1));
}

class Pyramid : public ::testing::Test {
 protected:
  static constexpr std::size_t kRows = 150'000;

  void write(bool seal) {
    auto numbers = noise(kRows, 21);
    numbers[777] = std::numeric_limits<float>::quiet_NaN();
    numbers[778] = std::numeric_limits<float>::infinity();
    StreamInfo stream = noise_stream();
    stream.channels[1].scale = 0.5;
    stream.channels[1].offset = 3.0;
    samples_.t_s = times(kRows, 0.01);
    samples_.values = values_of(column_of(numbers), 0.5, 3.0);
    auto writer = RunFileWriter::create(folder_ / "a.soakrun", run_info());
    ASSERT_TRUE(writer->add_stream(stream));
    ASSERT_TRUE(writer->append(0, {column_of(samples_.t_s), column_of(numbers)}));
    ASSERT_TRUE(writer->flush());
    if (seal) {
      ASSERT_TRUE(writer->seal());
    }
  }

  void expect_all_spans() const {
    const auto reader = RunFileReader::open(folder_ / "a.soakrun");
    ASSERT_TRUE(reader);
    for (const std::size_t max_bins : {1U, 3U, 20U, 290U, 1000U}) {
      for (const auto& [from_s, to_s] : std::vector<std::pair<double, double>>{
               {-1.0, 1e9}, {0.0, 1499.99}, {3.2, 3.7}, {100.0, 900.0}, {1400.0, 1499.0}, {1498.5, 2000.0}}) {
        const auto bins = reader->pyramid(0, 1, from_s, to_s, max_bins);
        ASSERT_TRUE(bins) << bins.error().message;
        EXPECT_LE(bins->size(), max_bins + 3) << from_s << " " << to_s;
        expect_bins_cover(*bins, samples_, from_s, to_s);
      }
    }
    const auto whole = reader->pyramid(0, 1, 0.0, 1499.99, 200);
    EXPECT_GE(whole->size(), 100U);
    EXPECT_TRUE(reader->pyramid(0, 1, 2000.0, 3000.0, 10)->empty());
    EXPECT_FALSE(reader->pyramid(0, 1, 2.0, 1.0, 10));
  }

  TempFolder folder_;
  Samples samples_;
};

TEST_F(Pyramid, EqualsBruteForceInASealedFile) {
  write(true);
  expect_all_spans();
}

TEST_F(Pyramid, EqualsBruteForceInAFileThatGrows) {
  write(false);
  expect_all_spans();
}

TEST_F(Pyramid, SurvivesTheLargestNumbers) {
  auto writer = RunFileWriter::create(folder_ / "b.soakrun", run_info());
  ASSERT_TRUE(writer->add_stream({"x", "", {channel("t_s", SampleType::f64), channel("v", SampleType::f64)}}));
  const double largest = std::numeric_limits<double>::max();
  ASSERT_TRUE(writer->append(0, {column_of(times(3, 1.0)), column_of(std::vector<double>{largest, largest, largest})}));
  ASSERT_TRUE(writer->seal());
  const auto reader = RunFileReader::open(folder_ / "b.soakrun");
  EXPECT_EQ(reader->pyramid(0, 1, 0.0, 2.0, 1)->front().mean, largest);
  EXPECT_TRUE(reader->verify());
}

}  // namespace
}  // namespace soak::db
