// SPDX-License-Identifier: Apache-2.0
// Run files: what goes in comes out, growing and sealed.
#include <bit>

#include <algorithm>
#include <cmath>

#include "db/run/run_file.h"
#include "tests/db/support.h"

namespace soak::db {
namespace {

using testing::bytes_of_file;
using testing::channel;
using testing::column_of;
using testing::noise;
using testing::noise_stream;
using testing::run_info;
using testing::TempFolder;
using testing::times;
using testing::write_noise_file;

TEST(RunFile, ScansAChannelChunkByChunkAsItIsReadAtOnce) {
  const TempFolder folder;
  constexpr std::size_t kRows = 40'000;  // two full chunks and a part
  StreamInfo stream{"imu", "SN1", {channel("t_s", SampleType::f64, "s"), channel("a", SampleType::i16)}};
  stream.channels[1].scale = 0.25;
  stream.channels[1].offset = -3.0;
  std::vector<std::int16_t> numbers(kRows);
  std::vector<std::uint8_t> present(kRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    numbers[i] = static_cast<std::int16_t>(i * 7919);
    present[i] = i % 3 == 0 ? 0 : 1;
  }
  auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_TRUE(writer && writer->add_stream(stream));
  ASSERT_TRUE(writer->append(0, {column_of(times(kRows, 0.005)), column_of(numbers, present)}));
  ASSERT_TRUE(writer->seal());
  const auto reader = RunFileReader::open(folder / "a.soakrun");
  ASSERT_TRUE(reader) << reader.error().message;
  std::vector<double> scanned;
  std::size_t longest = 0;
  ASSERT_TRUE(reader->scan(0, 1, [&](std::span<const double> values) {
    scanned.insert(scanned.end(), values.begin(), values.end());
    longest = std::max(longest, values.size());
  }));
  EXPECT_LT(longest, kRows);
  ASSERT_EQ(scanned.size(), kRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    ASSERT_TRUE(present[i] != 0 ? scanned[i] == 0.25 * numbers[i] - 3.0 : std::isnan(scanned[i])) << i;
  }
  EXPECT_FALSE(reader->scan(0, 2, [](std::span<const double>) {}));
}

TEST(RunFile, KeepsEveryTypeBitExactOverManyAppends) {
  const TempFolder folder;
  base::Random random(11);
  StreamInfo stream{"imu", "SN1", {channel("t_s", SampleType::f64, "s")}};
  for (int type = 0; type <= static_cast<int>(SampleType::f64); ++type) {
    stream.channels.push_back(channel("c" + std::to_string(type), static_cast<SampleType>(type)));
  }
  auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_TRUE(writer) << writer.error().message;
  ASSERT_TRUE(writer->add_stream(stream));
  std::vector<Column> expected(stream.channels.size());
  std::size_t rows = 0;
  while (rows < 40'000) {
    const auto count = static_cast<std::size_t>(random.uniform(1.0, 7000.0));
    std::vector<Column> columns = {column_of(times(count, 0.005, rows))};
    for (std::size_t i = 1; i < stream.channels.size(); ++i) {
      Column column{stream.channels[i].type, base::Bytes(count * size_of(stream.channels[i].type)), {}};
      for (auto& byte : column.raw) byte = static_cast<std::uint8_t>(random.next() >> 56);
      columns.push_back(column);
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      expected[i].type = columns[i].type;
      expected[i].raw.insert(expected[i].raw.end(), columns[i].raw.begin(), columns[i].raw.end());
    }
    ASSERT_TRUE(writer->append(0, columns));
    if (random.uniform() < 0.4) {
      ASSERT_TRUE(writer->flush());
    }
    rows += count;
  }
  ASSERT_TRUE(writer->seal());
  const auto reader = RunFileReader::open(folder / "a.soakrun");
  ASSERT_TRUE(reader) << reader.error().message;
  ASSERT_EQ(reader->rows(0), rows);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto column = reader->read(0, i);
    ASSERT_TRUE(column) << column.error().message;
    EXPECT_TRUE(*column == expected[i]) << "channel " << i;
    const auto part = reader->read(0, i, 16'000, 20'000);
    ASSERT_TRUE(part);
    const std::size_t size = size_of(expected[i].type);
    EXPECT_TRUE(std::equal(part->raw.begin(), part->raw.end(),
                           expected[i].raw.begin() + static_cast<std::ptrdiff_t>(16'000 * size)));
    EXPECT_EQ(part->rows(), 20'000U);
  }
  EXPECT_TRUE(reader->verify());
}

TEST(RunFile, KeepsAbsentRowsAcrossChunks) {
  const TempFolder folder;
  const std::size_t rows = 40'000;
  std::vector<std::int32_t> numbers(rows);
  std::vector<std::uint8_t> present(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    present[i] = i % 200 == 0 && i < 30'000 ? 1 : 0;
    numbers[i] = present[i] != 0 ? static_cast<std::int32_t>(i) - 7 : 0;
  }
  const auto slow = column_of(numbers, present);
  auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_TRUE(writer->add_stream(
      {"imu", "", {channel("t_s", SampleType::f64, "s"), channel("chamber_c", SampleType::i32, "c")}}));
  ASSERT_TRUE(writer->append(0, {column_of(times(rows, 0.005)), slow}));
  ASSERT_TRUE(writer->seal());
  const auto reader = RunFileReader::open(folder / "a.soakrun");
  EXPECT_TRUE(*reader->read(0, 1) == slow);
  EXPECT_TRUE(reader->verify());
}

TEST(RunFile, KeepsWhatTheRunSaysOfItself) {
  const TempFolder folder;
  StreamInfo stream = noise_stream();
  stream.channels[1].scale = 0.1;
  stream.channels[1].offset = -1e-300;
  stream.channels[1].source_name = "Gyro \xC3\x97 [\xC2\xB0/s]";
  stream.channels.push_back(channel("position", SampleType::u8, "label"));
  stream.channels[2].labels = {"+X", "a \"b\", \\ \n", "", "\xC3\xA9"};
  {
    auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
    ASSERT_TRUE(writer->add_stream(stream));
    ASSERT_TRUE(writer->add_stream({"chamber", "", {channel("t_s", SampleType::f64, "s")}}));
    ASSERT_TRUE(writer->add_event(1.5, "door", "opened"));
    ASSERT_TRUE(writer->seal());
  }
  const auto reader = RunFileReader::open(folder / "a.soakrun");
  ASSERT_TRUE(reader) << reader.error().message;
  const RunInfo& info = reader->info();
  EXPECT_EQ(info.run_id, run_info().run_id);
  EXPECT_EQ(info.label, run_info().label);
  EXPECT_EQ(info.campaign, "c1");
  EXPECT_EQ(info.procedure, "soak");
  EXPECT_EQ(info.purpose, "verification");
  EXPECT_EQ(info.created_utc_s, 1700000000.125);
  EXPECT_EQ(info.clock_rate, 20.0);
  EXPECT_TRUE(info.simulated);
  EXPECT_EQ(info.source, "import a.csv");
  EXPECT_EQ(info.site, run_info().site);
  ASSERT_EQ(reader->streams().size(), 2U);
  EXPECT_EQ(reader->streams()[0].channels, stream.channels);
  EXPECT_EQ(reader->streams()[0].unit, "SN1");
  EXPECT_EQ(reader->streams()[1].name, "chamber");
  EXPECT_EQ(reader->rows(1), 0U);
  EXPECT_EQ(reader->read(1, 0)->rows(), 0U);
  EXPECT_TRUE(reader->pyramid(1, 0, 0.0, 1.0, 10)->empty());
  const auto events = reader->events();
  ASSERT_EQ(events->size(), 1U);
  EXPECT_EQ(events->front().kind, "door");
}

TEST(RunFile, RefusesRowsThatHaveNoMeaning) {
  const TempFolder folder;
  auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_TRUE(writer->add_stream(noise_stream()));
  const auto refused = [&](const std::vector<Column>& columns) {
    const auto status = writer->append(0, columns);
    return !status && status.error().kind == base::ErrorKind::bad_input;
  };
  EXPECT_TRUE(refused({column_of(times(3, 1.0))}));
  EXPECT_TRUE(refused({column_of(times(3, 1.0)), column_of(noise(4, 1))}));
  EXPECT_TRUE(refused({column_of(times(3, 1.0)), column_of(times(3, 1.0))}));
  EXPECT_TRUE(refused({column_of(std::vector<double>{0, 2, 1}), column_of(noise(3, 1))}));
  EXPECT_TRUE(refused({column_of(std::vector<double>{0, NAN, 1}), column_of(noise(3, 1))}));
  EXPECT_TRUE(refused({column_of(times(3, 1.0), {1, 0, 1}), column_of(noise(3, 1))}));
  ASSERT_TRUE(writer->append(0, {column_of(std::vector<double>{5.0}), column_of(noise(1, 1))}));
  EXPECT_TRUE(refused({column_of(std::vector<double>{4.0}), column_of(noise(1, 1))}));
  EXPECT_FALSE(writer->add_stream(noise_stream()));
  EXPECT_FALSE(writer->add_stream({"x", "", {channel("temp_c", SampleType::f64)}}));
  EXPECT_FALSE(writer->add_stream({"x", "", {}}));
  ASSERT_TRUE(writer->seal());
  EXPECT_FALSE(writer->append(0, {column_of(std::vector<double>{6.0}), column_of(noise(1, 1))}));
  EXPECT_EQ(RunFileReader::open(folder / "a.soakrun")->rows(0), 1U);
}

TEST(RunFile, RefusesAPathThatExistsAndLeavesItAlone) {
  const TempFolder folder;
  std::ofstream(folder / "a.soakrun") << "precious";
  const auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(bytes_of_file(folder / "a.soakrun"), "precious");
}

TEST(RunFile, IsReadableWhileItGrowsAndAfterAnAbandonedWriter) {
  const TempFolder folder;
  {
    auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
    ASSERT_TRUE(writer->add_stream(noise_stream()));
    std::size_t rows = 0;
    for (const std::size_t count : {100U, 20'000U, 1U, 50'000U}) {
      ASSERT_TRUE(writer->append(0, {column_of(times(count, 0.01, rows)), column_of(noise(count, rows))}));
      ASSERT_TRUE(writer->flush());
      rows += count;
      const auto reader = RunFileReader::open(folder / "a.soakrun");
      ASSERT_TRUE(reader) << reader.error().message;
      EXPECT_FALSE(reader->sealed());
      EXPECT_EQ(reader->rows(0), rows);
      EXPECT_TRUE(reader->verify());
    }
    ASSERT_TRUE(writer->append(0, {column_of(times(5, 0.01, rows)), column_of(noise(5, rows))}));  // never flushed
  }
  const auto reader = RunFileReader::open(folder / "a.soakrun");
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->rows(0), 70'101U);
  EXPECT_TRUE(reader->verify());
}

TEST(RunFile, SealsIntoOneFileThatReadingLeavesAlone) {
  const TempFolder folder;
  write_noise_file(folder / "a.soakrun", 50'000);
  const std::string before = bytes_of_file(folder / "a.soakrun");
  {
    const auto reader = RunFileReader::open(folder / "a.soakrun");
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->sealed());
    EXPECT_TRUE(reader->verify());
    EXPECT_TRUE(reader->content_hash());
    EXPECT_TRUE(reader->pyramid(0, 1, 0.0, 500.0, 20));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  }
  EXPECT_EQ(bytes_of_file(folder / "a.soakrun"), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(RunFile, CanBeSealedLaterWhenAReaderHeldItOpen) {
  const TempFolder folder;
  auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
  ASSERT_TRUE(writer->add_stream(noise_stream()));
  ASSERT_TRUE(writer->append(0, {column_of(times(1000, 0.01)), column_of(noise(1000, 1))}));
  ASSERT_TRUE(writer->flush());
  {
    const auto reader = RunFileReader::open(folder / "a.soakrun");
    const auto blocked = writer->seal();
    ASSERT_FALSE(blocked);
    EXPECT_EQ(blocked.error().kind, base::ErrorKind::internal);
    EXPECT_TRUE(reader->verify());
  }
  EXPECT_TRUE(writer->seal());
  EXPECT_TRUE(RunFileReader::open(folder / "a.soakrun")->sealed());
}

TEST(RunFile, HashesTheSamplesAndNotTheLayout) {
  const TempFolder folder;
  const std::size_t rows = 20'000;
  const auto write = [&](const char* name, std::size_t step, const RunInfo& info, float change, const char* unit) {
    auto writer = RunFileWriter::create(folder / name, info);
    StreamInfo stream = noise_stream();
    stream.channels[1].unit = unit;
    EXPECT_TRUE(writer->add_stream(stream));
    auto values = noise(rows, 7);
    values[12'345] += change;
    for (std::size_t first = 0; first < rows; first += step) {
      const std::size_t count = std::min(step, rows - first);
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
      const std::vector<float> part(begin, begin + static_cast<std::ptrdiff_t>(count));
      EXPECT_TRUE(writer->append(0, {column_of(times(count, 0.01, first)), column_of(part)}));
      if (step < rows) {
        EXPECT_TRUE(writer->flush());
      }
    }
    EXPECT_TRUE(writer->flush());
    return *RunFileReader::open(folder / name)->content_hash();
  };
  RunInfo other = run_info();
  other.run_id = "01890a5d-ac96-774b-bcce-b302099a8058";
  other.label = "another";
  const std::string hash = write("a", rows, run_info(), 0.0F, "dps");
  EXPECT_EQ(hash.size(), 64U);
  EXPECT_EQ(write("b", 3000, other, 0.0F, "dps"), hash);
  EXPECT_NE(write("c", rows, run_info(), 0.5F, "dps"), hash);
  EXPECT_NE(write("d", rows, run_info(), 0.0F, "rps"), hash);
}

TEST(RunFile, PrintsItsSummaryInThePlainShell) {
  if (std::system("command -v sqlite3 > /dev/null") != 0) GTEST_SKIP() << "no sqlite3 command here";
  const TempFolder folder;
  write_noise_file(folder / "a.soakrun", 3000);
  const std::string command = "sqlite3 -readonly '" + (folder / "a.soakrun").string() +
                              "' 'SELECT channel, row_count, minimum, maximum FROM "
                              "summary; SELECT value FROM meta WHERE key = \"run_id\"'";
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output(4096, '\0');
  output.resize(std::fread(output.data(), 1, output.size(), pipe));
  EXPECT_EQ(::pclose(pipe), 0);
  EXPECT_EQ(output.rfind("t_s|3000|0.0|29.99\nvalue|3000|", 0), 0U) << output;
  EXPECT_NE(output.find(run_info().run_id), std::string::npos) << output;
}

}  // namespace
}  // namespace soak::db
