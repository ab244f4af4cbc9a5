// SPDX-License-Identifier: Apache-2.0
// Recording 64 units of 200 Hz, time and seven channels: processor time per second of recording and bytes a value,
// beside the entropy of the values, and beside SQLite with a row per sample, committed as often. Then the questions of
// a page about a run of 35 hours at 100 Hz: a thousand bins of any channel over any span, and every sample of ten
// minutes, from a file that is opened anew and is not in memory, beside a plain read of the whole file. The first
// argument is another number of recorded seconds, the second one another number of hours.
#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.h"
#include "db/run/run_file.h"

namespace soak::db {
namespace {

constexpr std::size_t kUnits = 64;
constexpr std::size_t kChannels = 7;  ///< beside the time
constexpr double kRate_hz = 200.0;
constexpr std::size_t kRowsAtOnce = 2;  ///< what 10 ms bring
constexpr double kFlush_s = 5.0;        ///< as soakd does
constexpr double kSigmaCounts = 2.0;    ///< white noise of an integer unit, over its step
constexpr double kSigma = 0.002;        ///< of one that sends float32, over an offset of 0.1 to 0.7

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Stopwatch {
 public:
  [[nodiscard]] double elapsed_ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Ends the program where a result is an error.
template <class T>
T must(base::Result<T> result) {
  if (result) return *std::move(result);
  fmt::print(stderr, "{}: {}\n", result.error().where, result.error().message);
  std::exit(1);
}

void must(const base::Status& status) {
  if (status) return;
  fmt::print(stderr, "{}: {}\n", status.error().where, status.error().message);
  std::exit(1);
}

/// A folder that is gone at the end.
struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / fmt::format("soak-record-{}", ::getpid());
  Folder() { std::filesystem::create_directory(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
};

double offset_of(std::size_t channel) { return 0.1 * static_cast<double>(channel + 1); }

/// Sample `row` of a channel: counts of an integer unit, or what a unit sends as float32.
double value_of(std::size_t unit, std::size_t channel, std::size_t row, bool whole) {
  const double noise = base::hashed_gaussian(unit, channel, row);
  return whole ? std::round(100.0 * offset_of(channel) + kSigmaCounts * noise)
               : static_cast<double>(static_cast<float>(offset_of(channel) + kSigma * noise));
}

template <class T>
Column column_of(SampleType type, const std::vector<double>& values) {
  std::vector<T> numbers(values.size());
  std::transform(values.begin(), values.end(), numbers.begin(), [](double v) { return static_cast<T>(v); });
  Column column{type, base::Bytes(numbers.size() * sizeof(T)), {}};
  std::memcpy(column.raw.data(), numbers.data(), column.raw.size());
  return column;
}

std::vector<Column> rows_of(std::size_t unit, std::size_t first, std::size_t count, double rate_hz, bool whole) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<double>(first + i) / rate_hz;
  std::vector<Column> columns = {column_of<double>(SampleType::f64, values)};
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    for (std::size_t i = 0; i < count; ++i) values[i] = value_of(unit, channel, first + i, whole);
    columns.push_back(whole ? column_of<std::int16_t>(SampleType::i16, values)
                            : column_of<float>(SampleType::f32, values));
  }
  return columns;
}

StreamInfo stream_of(std::size_t unit, bool whole) {
  StreamInfo stream{"imu", fmt::format("SN{}", unit), {{"t_s", "t_s", SampleType::f64, "s", 1.0, 0.0, {}}}};
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    const std::string name = fmt::format("channel_{}", channel);
    stream.channels.push_back({name, name, whole ? SampleType::i16 : SampleType::f32, "rps", 1.0, 0.0, {}});
  }
  return stream;
}

RunFileWriter new_file(const std::filesystem::path& path) {
  RunInfo info;
  info.run_id = "01920000-0000-7000-8000-000000000000";
  info.label = "bench";
  return must(RunFileWriter::create(path, info));
}

/// Bits of information in a value, in bytes: what no lossless code can go below on the average.
double entropy_bytes(bool whole) {
  constexpr std::size_t kDraws = 100'000;
  double bits = 0.0;
  for (std::size_t i = 0; i < kDraws; ++i) {
    const std::size_t channel = i % kChannels;
    const double sigma = whole ? kSigmaCounts : kSigma;
    const double value = value_of(0, channel, i, whole);
    const double z = (value - (whole ? 100.0 : 1.0) * offset_of(channel)) / sigma;
    const double density = std::exp(-0.5 * z * z) / (sigma * std::sqrt(2.0 * std::numbers::pi));
    const double step = whole ? 1.0 : std::exp2(std::floor(std::log2(std::abs(value))) - 23.0);
    bits -= std::log2(density * step);
  }
  return bits / 8.0 / static_cast<double>(kDraws);
}

// --- recording --------------------------------------------------------------------------------------------------

struct Cost {
  double processor_s = 0.0;
  double bytes = 0.0;
};

/// Calls `take(unit, columns, first row)` for what each ten milliseconds bring, and `flush` every five seconds. The
/// processor time is that of the calls alone, and is read twice in five seconds: to ask for it at each call costs as
/// much as a call.
template <class Take, class Flush>
double recorded_s(double seconds, bool whole, const Take& take, const Flush& flush) {
  double used_s = 0.0;
  const auto count = static_cast<std::size_t>(seconds * kRate_hz);
  const auto rows_to_flush = static_cast<std::size_t>(kFlush_s * kRate_hz);
  std::vector<std::vector<Column>> arrived;
  for (std::size_t first = 0; first < count; first += rows_to_flush) {
    arrived.clear();
    for (std::size_t row = first; row < std::min(count, first + rows_to_flush); row += kRowsAtOnce) {
      for (std::size_t unit = 0; unit < kUnits; ++unit)
        arrived.push_back(rows_of(unit, row, kRowsAtOnce, kRate_hz, whole));
    }
    const double begin_s = processor_s();
    for (std::size_t i = 0; i < arrived.size(); ++i) take(i % kUnits, arrived[i], first + i / kUnits * kRowsAtOnce);
    flush();
    used_s += processor_s() - begin_s;
  }
  return used_s;
}

Cost record(const std::filesystem::path& path, double seconds, bool whole) {
  RunFileWriter file = new_file(path);
  for (std::size_t unit = 0; unit < kUnits; ++unit) (void)must(file.add_stream(stream_of(unit, whole)));
  const double used_s = recorded_s(
      seconds, whole, [&](std::size_t unit, const auto& columns, std::size_t) { must(file.append(unit, columns)); },
      [&] { must(file.flush()); });
  const double begin_s = processor_s();
  (void)must(file.seal());
  return {used_s + processor_s() - begin_s, static_cast<double>(std::filesystem::file_size(path))};
}

void execute(sqlite3* db, const char* sql) {
  if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) == SQLITE_OK) return;
  fmt::print(stderr, "{}: {}\n", sql, sqlite3_errmsg(db));
  std::exit(1);
}

double number_at(const Column& column, std::size_t row, bool whole) {
  std::int16_t counts = 0;
  float number = 0.0F;
  if (whole) {
    std::memcpy(&counts, column.raw.data() + row * sizeof counts, sizeof counts);
    return counts;
  }
  std::memcpy(&number, column.raw.data() + row * sizeof number, sizeof number);
  return static_cast<double>(number);
}

/// The peer: a table with a row per sample.
Cost record_in_rows(const std::filesystem::path& path, double seconds, bool whole) {
  sqlite3* db = nullptr;
  if (sqlite3_open(path.c_str(), &db) != SQLITE_OK) std::exit(1);
  execute(db, "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
  execute(db, "CREATE TABLE sample (unit INTEGER, t_s REAL, a, b, c, d, e, f, g)");
  execute(db, "BEGIN");
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO sample VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", -1, &insert, nullptr);
  const auto take = [&](std::size_t unit, const std::vector<Column>& columns, std::size_t first) {
    for (std::size_t row = 0; row < kRowsAtOnce; ++row) {
      sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(unit));
      sqlite3_bind_double(insert, 2, static_cast<double>(first + row) / kRate_hz);
      for (std::size_t channel = 0; channel < kChannels; ++channel) {
        const double value = number_at(columns[channel + 1], row, whole);
        const int place = static_cast<int>(channel) + 3;
        whole ? sqlite3_bind_int64(insert, place, static_cast<sqlite3_int64>(value))
              : sqlite3_bind_double(insert, place, value);
      }
      if (sqlite3_step(insert) != SQLITE_DONE) std::exit(1);
      sqlite3_reset(insert);
    }
  };
  double used_s = recorded_s(seconds, whole, take, [&] { execute(db, "COMMIT; BEGIN"); });
  const double begin_s = processor_s();
  execute(db, "COMMIT; PRAGMA wal_checkpoint(TRUNCATE)");
  used_s += processor_s() - begin_s;
  sqlite3_finalize(insert);
  sqlite3_close(db);
  return {used_s, static_cast<double>(std::filesystem::file_size(path))};
}

void compare_recording(const Folder& folder, double seconds, bool whole) {
  const double values = seconds * kRate_hz * static_cast<double>(kUnits * kChannels);
  const Cost ours = record(folder.path / "run.soakrun", seconds, whole);
  const Cost rows = record_in_rows(folder.path / "rows.db", seconds, whole);
  fmt::print("{}, {} units of {:.0f} Hz, time and {} channels, {:.0f} s\n", whole ? "int16" : "float32", kUnits,
             kRate_hz, kChannels, seconds);
  fmt::print(
      "  run file           {:6.2f} % of a core   {:6.3f} bytes a value (entropy {:.3f}, the time included in ours)\n",
      100.0 * ours.processor_s / seconds, ours.bytes / values, entropy_bytes(whole));
  fmt::print(
      "  a row per sample   {:6.2f} % of a core   {:6.3f} bytes a value: {:.1f} times the time, {:.1f} times the "
      "bytes\n",
      100.0 * rows.processor_s / seconds, rows.bytes / values, rows.processor_s / ours.processor_s,
      rows.bytes / ours.bytes);
  std::filesystem::remove(folder.path / "run.soakrun");
  std::filesystem::remove(folder.path / "rows.db");
}

// --- a page's questions -----------------------------------------------------------------------------------------

/// Takes the file out of the computer's memory.
void forget(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ::fsync(fd);
  ::posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
  ::close(fd);
}

double plain_read_ms(const std::filesystem::path& path) {
  forget(path);
  const Stopwatch watch;
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  std::vector<char> piece(1 << 20);
  while (::read(fd, piece.data(), piece.size()) > 0) {
  }
  ::close(fd);
  return watch.elapsed_ms();
}

/// The longest of some times, and their median.
std::string times_text(std::vector<double> times_ms) {
  std::sort(times_ms.begin(), times_ms.end());
  return fmt::format("median {:6.1f} ms, longest {:6.1f} ms of {}", times_ms[times_ms.size() / 2], times_ms.back(),
                     times_ms.size());
}

void time_questions(const Folder& folder, double hours) {
  constexpr double kSlowRate_hz = 100.0;
  constexpr std::size_t kPiece = 100'000;
  const auto path = folder.path / "long.soakrun";
  const auto count = static_cast<std::size_t>(hours * 3600.0 * kSlowRate_hz);
  RunFileWriter file = new_file(path);
  (void)must(file.add_stream(stream_of(0, false)));
  for (std::size_t first = 0; first < count; first += kPiece) {
    must(file.append(0, rows_of(0, first, std::min(kPiece, count - first), kSlowRate_hz, false)));
  }
  (void)must(file.seal());
  std::vector<double> plots_ms;
  std::vector<double> samples_ms;
  const double end_s = hours * 3600.0;
  base::Random random(1, 1);
  for (int trial = 0; trial < 60; ++trial) {
    const double length_s = end_s * std::pow(10.0, -random.uniform(0.0, 4.0));
    const double from_s = random.uniform(0.0, end_s - length_s);
    const std::size_t channel = 1 + static_cast<std::size_t>(trial) % kChannels;
    forget(path);
    const Stopwatch plot;
    (void)must(must(RunFileReader::open(path)).pyramid(0, channel, from_s, from_s + length_s, 1000));
    plots_ms.push_back(plot.elapsed_ms());
    const double begin_s = random.uniform(0.0, end_s - 600.0);
    forget(path);
    const Stopwatch segment;
    const auto reader = must(RunFileReader::open(path));
    const RowSpan span = must(reader.rows_between(0, begin_s, begin_s + 600.0));
    (void)must(reader.read(0, channel, span.first, span.count));
    samples_ms.push_back(segment.elapsed_ms());
  }
  fmt::print("a run of {:.0f} h at {:.0f} Hz, file of {:.0f} MB, not in memory; to read it plainly takes {:.0f} ms\n",
             hours, kSlowRate_hz, static_cast<double>(std::filesystem::file_size(path)) / 1e6, plain_read_ms(path));
  fmt::print("  a thousand bins of any channel over any span   {}\n", times_text(plots_ms));
  fmt::print("  every sample of ten minutes of a channel       {}\n", times_text(samples_ms));
}

int run(double seconds, double hours) {
  const Folder folder;
  compare_recording(folder, seconds, true);
  compare_recording(folder, seconds, false);
  time_questions(folder, hours);
  return 0;
}

}  // namespace
}  // namespace soak::db

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 0.0;
  const double hours = argc > 2 ? std::atof(argv[2]) : 0.0;
  return soak::db::run(seconds > 0.0 ? seconds : 60.0, hours > 0.0 ? hours : 35.0);
}
