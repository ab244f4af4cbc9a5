// SPDX-License-Identifier: Apache-2.0
// A 20-hour run of one unit at 200 Hz, 14.4 million rows of six sensors and a thermometer, from its run file to segment
// statistics with the data gate: the time of each stage (the best of a few passes: the first finds memory that nobody
// has touched before), and that of a plain read of as many doubles in the same run.
// The first argument is another number of hours.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "db/run/run_file.h"
#include "station/runs/recording_reader.h"

namespace soak {
namespace {

constexpr double kRate_hz = 200.0;
constexpr double kVisit_s = 3600.0;
constexpr double kRamp_s = 600.0;

/// Processor time of this program, which has one thread: other load on the machine does not count.
class Stopwatch {
 public:
  double lap_s() {
    const std::clock_t now = std::clock();
    const double seconds = static_cast<double>(now - since_) / CLOCKS_PER_SEC;
    since_ = now;
    return seconds;
  }

 private:
  std::clock_t since_ = std::clock();
};

template <class T>
db::Column column_of(db::SampleType type, const std::vector<T>& values) {
  db::Column column{type, base::Bytes(values.size() * sizeof(T)), {}};
  std::memcpy(column.raw.data(), values.data(), column.raw.size());
  return column;
}

db::ChannelInfo channel(const std::string& name, db::SampleType type, const std::string& unit) {
  return {name, name, type, unit, 1.0, 0.0, {}};
}

std::vector<db::ChannelInfo> channels() {
  std::vector<db::ChannelInfo> list = {channel("t_s", db::SampleType::f64, "s")};
  for (const calib::Sensor sensor : calib::kSensors) {
    list.push_back(
        channel(std::string(calib::name_of(sensor)), db::SampleType::f32, calib::is_gyro(sensor) ? "rps" : "mps2"));
  }
  list.push_back(channel("temp_c", db::SampleType::f32, "c"));
  list.push_back(channel("plateau_c", db::SampleType::f32, "c"));
  list.push_back(channel("position", db::SampleType::u8, "label"));
  list.back().labels = {"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
  list.push_back(channel("phase", db::SampleType::u8, "label"));
  list.back().labels = {"soak", "ramp"};
  return list;
}

/// Rows [first, first + count) of the made-up run: visits of an hour, each begins with a ramp of ten minutes, then six
/// positions.
std::vector<db::Column> rows(std::size_t first, std::size_t count) {
  std::vector<double> t_s;
  std::vector<std::vector<float>> numbers(8);
  std::vector<std::uint8_t> position;
  std::vector<std::uint8_t> phase;
  for (std::size_t i = first; i < first + count; ++i) {
    const double t = static_cast<double>(i) / kRate_hz;
    const double in_visit_s = std::fmod(t, kVisit_s);
    const auto p = static_cast<std::uint8_t>(std::min(5.0, std::max(0.0, (in_visit_s - kRamp_s) / 500.0)));
    const double plateau_c = -30.0 + 5.0 * std::floor(t / kVisit_s);
    t_s.push_back(t);
    position.push_back(p);
    phase.push_back(in_visit_s < kRamp_s ? 1 : 0);
    for (std::size_t s = 0; s < 6; ++s) {
      const double force = s == 3U + p / 2U ? (p % 2U == 0U ? 9.81 : -9.81) : 0.0;
      numbers[s].push_back(static_cast<float>(force + 0.002 * base::hashed_gaussian(1, s, i)));
    }
    numbers[6].push_back(static_cast<float>(plateau_c + 0.02 * base::hashed_gaussian(1, 6, i)));
    numbers[7].push_back(static_cast<float>(plateau_c));
  }
  std::vector<db::Column> columns = {column_of(db::SampleType::f64, t_s)};
  for (const auto& values : numbers) columns.push_back(column_of(db::SampleType::f32, values));
  columns.push_back(column_of(db::SampleType::u8, position));
  columns.push_back(column_of(db::SampleType::u8, phase));
  return columns;
}

/// Ends the program where a result is an error.
template <class T>
T must(base::Result<T> result) {
  if (result) return *std::move(result);
  fmt::print(stderr, "{}: {}\n", result.error().where, result.error().message);
  std::exit(1);
}

void write_run(const std::filesystem::path& path, std::size_t count) {
  db::RunInfo info;
  info.run_id = "01920000-0000-7000-8000-000000000000";
  info.label = "bench";
  auto file = must(db::RunFileWriter::create(path, info));
  const std::size_t stream = must(file.add_stream({"imu", "SN1", channels()}));
  constexpr std::size_t kPiece = 200000;
  for (std::size_t first = 0; first < count; first += kPiece) {
    if (auto status = file.append(stream, rows(first, std::min(kPiece, count - first))); !status) std::exit(1);
  }
  must(file.seal());
}

double read_doubles_s(std::size_t count) {
  const std::vector<double> values(count, 1.0);
  Stopwatch watch;
  double sum = 0.0;
  for (const double value : values) sum += value;
  const double seconds = watch.lap_s();
  return sum > 0.0 ? seconds : 0.0;
}

void report(const char* stage, double seconds, std::size_t samples) {
  fmt::print("{:<34} {:7.3f} s  {:6.2f} ns per sample\n", stage, seconds, 1e9 * seconds / static_cast<double>(samples));
}

/// Processor time of each stage.
struct Stages {
  double read_s = 0.0;
  double segment_s = 0.0;
  double gate_s = 0.0;
  std::size_t segments = 0;
  std::size_t findings = 0;

  [[nodiscard]] double total_s() const { return read_s + segment_s + gate_s; }
};

/// As soakd enters a run: one sensor in memory at a time.
Stages reduce(const std::filesystem::path& path) {
  Stages stages;
  Stopwatch watch;
  const auto file = must(db::RunFileReader::open(path));
  const auto axes = must(station::read_axes(file, "SN1"));
  stages.read_s += watch.lap_s();
  auto segmenter = must(calib::Segmenter::begin(axes));
  const calib::Segmentation& segmentation = segmenter.result();
  stages.segment_s += watch.lap_s();
  calib::Examination examination(axes, segmentation.segments, {});
  stages.gate_s += watch.lap_s();
  std::vector<double> samples;
  for (const calib::Sensor sensor : calib::kSensors) {
    if (!station::read_sensor(file, "SN1", sensor, samples)) std::exit(1);
    stages.read_s += watch.lap_s();
    segmenter.describe(sensor, samples);
    stages.segment_s += watch.lap_s();
    examination.add(sensor, samples);
    stages.gate_s += watch.lap_s();
  }
  for (const auto& list : examination.findings()) stages.findings += list.size();
  stages.gate_s += watch.lap_s();
  stages.segments = segmentation.segments.size();
  return stages;
}

double most_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

int run(double hours) {
  constexpr int kPasses = 5;
  const auto count = static_cast<std::size_t>(hours * 3600.0 * kRate_hz);
  const std::size_t samples = 7 * count;
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() /
      fmt::format("soak-reduce-{}.soakrun", std::chrono::steady_clock::now().time_since_epoch().count());
  write_run(path, count);
  std::vector<Stages> passes;
  for (int pass = 0; pass < kPasses; ++pass) {
    passes.push_back(reduce(path));
    fmt::print("pass {}: {:.3f} s\n", pass + 1, passes.back().total_s());
  }
  const Stages best = *std::min_element(passes.begin(), passes.end(),
                                        [](const Stages& a, const Stages& b) { return a.total_s() < b.total_s(); });
  fmt::print("{} rows, {} segments, {} findings, file of {} MB, {:.0f} MB of memory at most; the best of {} passes:\n",
             count, best.segments, best.findings, std::filesystem::file_size(path) / 1000000, most_memory_mb(),
             kPasses);
  report("read and convert", best.read_s, samples);
  report("segments and their statistics", best.segment_s, samples);
  report("from the file to statistics", best.read_s + best.segment_s, samples);
  report("data gate", best.gate_s, samples);
  report("all of it", best.total_s(), samples);
  report("a sum over as many doubles", read_doubles_s(samples), samples);
  std::filesystem::remove(path);
  return 0;
}

}  // namespace
}  // namespace soak

int main(int argc, char** argv) { return soak::run(argc > 1 ? std::strtod(argv[1], nullptr) : 20.0); }
