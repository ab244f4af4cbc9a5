// SPDX-License-Identifier: Apache-2.0
// A large store: what questions cost a catalog of 10,000 units and 200,000 runs, beside the limit of 100 ms; how fast
// all units of a smaller one are fitted on one thread and on all cores, and how that grows with their number.
#include <fmt/format.h>

#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "base/random.h"
#include "base/text.h"
#include "calib/vocabulary/position.h"
#include "calib/vocabulary/segment.h"
#include "db/catalog/catalog.h"
#include "station/fit/fit_batch.h"

namespace soak {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kUtc_s = 1.7e9;
constexpr double kGravity_mps2 = 9.80665;
constexpr double kLimit_ms = 100.0;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Ends the program where something cannot be done.
void demand(const base::Status& status) {
  if (status) return;
  fmt::print(stderr, "bench_store: {}\n", status.error().message);
  std::exit(1);
}

struct StoreSize {
  int units = 0;
  int runs = 0;
  int plateaus = 0;  ///< six positions at each, on the way up and on the way down
};

std::string serial_of(int unit) { return fmt::format("SN{:05}", unit); }

/// A curve of its own for each unit and sensor, in SI.
double bias_of(int unit, std::size_t sensor, double temp_c) {
  const double phase = 0.7 * unit + 1.3 * static_cast<double>(sensor);
  const double size = sensor < 3 ? 0.002 : 0.02;
  return size * (std::atan((temp_c - 20.0 - 10.0 * std::sin(phase)) / 25.0) + 0.3 * std::sin(phase + temp_c / 40.0));
}

/// One visit of six positions.
void add_visit(const db::RunRow& run, int unit, int visit, double plateau_c, calib::Sweep sweep,
               const std::array<double, 6>& offset, base::Random& random, std::vector<calib::Segment>& segments) {
  constexpr double kCount = 6000.0;
  for (std::size_t p = 0; p < calib::kSixPositionLabels.size(); ++p) {
    calib::Segment segment;
    segment.key = {run.run_id, run.unit, visit, std::string(calib::kSixPositionLabels[p]), 0};
    segment.sweep = sweep;
    segment.plateau_c = plateau_c;
    segment.position = calib::position_named(calib::kSixPositionLabels[p]);
    segment.t_start_s = 1200.0 * visit + 70.0 * static_cast<double>(p);
    segment.t_end_s = segment.t_start_s + 60.0;
    segment.temp_c = plateau_c + 0.5 + 0.02 * random.gaussian();
    segment.sensor_temp_c.fill(segment.temp_c);
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      const double noise = s < 3 ? 2e-4 : 2e-3;
      const bool along = s >= 3 && p / 2 == s - 3;
      const double force_mps2 = along ? (p % 2 == 0 ? kGravity_mps2 : -kGravity_mps2) : 0.0;
      const double error = noise / std::sqrt(kCount);
      segment.sensor[s] = {static_cast<std::size_t>(kCount),
                           force_mps2 + bias_of(unit, s, segment.temp_c) + offset[s] + error * random.gaussian(),
                           noise * noise, error};
    }
    segments.push_back(std::move(segment));
  }
}

void add_run(db::Catalog& catalog, const StoreSize& size, int unit, int number, base::Random& random) {
  db::RunRow run;
  run.run_id = fmt::format("{:08x}-0000-7000-8000-{:012x}", number, unit);
  run.unit = serial_of(unit);
  run.campaign = fmt::format("lot {}", unit / 50);
  run.label = fmt::format("R{:02}", number + 1);
  run.procedure = "thesis-soak";
  run.created_utc_s = kUtc_s + 86400.0 * number + unit;
  run.sealed = true;
  run.file_name = run.run_id + ".soakrun";
  run.file_sha256 = run.content_sha256 = fmt::format("{:032x}{:032x}", number, unit);
  run.site.gravity_mps2 = kGravity_mps2;
  std::array<double, 6> offset{};
  for (std::size_t s = 0; s < offset.size(); ++s) offset[s] = (s < 3 ? 2e-5 : 2e-4) * random.gaussian();
  std::vector<calib::Segment> segments;
  for (int k = 0; k < 2 * size.plateaus; ++k) {
    const bool up = k < size.plateaus;
    const int step = up ? k : 2 * size.plateaus - 1 - k;
    const double plateau_c = -30.0 + 100.0 * step / std::max(1, size.plateaus - 1);
    add_visit(run, unit, k, plateau_c, up ? calib::Sweep::up : calib::Sweep::down, offset, random, segments);
  }
  demand(catalog.add_run(run, segments));
  // Statistics are all that there is: the samples count as dropped.
  demand(catalog.add_sample_drop({run.run_id, "bench_store", 0, "made without samples", "bench_store", kUtc_s}));
}

db::Catalog made_store(const std::filesystem::path& folder, const StoreSize& size) {
  std::filesystem::remove_all(folder);
  auto catalog = db::Catalog::open(folder);
  demand(catalog ? base::Status() : base::forward_error(catalog));
  base::Random random(1);
  for (int unit = 0; unit < size.units; ++unit) {
    demand(catalog->all_or_nothing([&]() -> base::Status {
      demand(catalog->ensure_campaign(fmt::format("lot {}", unit / 50), "thesis-soak"));
      if (const auto row = catalog->ensure_unit(serial_of(unit), "generic"); !row) return base::forward_error(row);
      for (int number = 0; number < size.runs; ++number) add_run(*catalog, size, unit, number, random);
      return {};
    }));
  }
  return *std::move(catalog);
}

void ask(const char* what, const std::function<std::size_t()>& question) {
  constexpr int kRepetitions = 5;
  std::size_t rows = question();
  const auto start = Clock::now();
  for (int i = 0; i < kRepetitions; ++i) rows = question();
  const double ms = 1e3 * seconds_since(start) / kRepetitions;
  fmt::print("  {:<28} {:>8} rows {:>9.2f} ms   {:.3f} of the limit\n", what, rows, ms, ms / kLimit_ms);
}

void ask_all(const db::Catalog& catalog, const std::string& serial) {
  ask("units", [&] { return catalog.units()->size(); });
  ask("runs of a unit", [&] { return catalog.runs({.unit = serial, .campaign = {}, .run = {}})->size(); });
  ask("runs of a campaign", [&] { return catalog.runs({.unit = {}, .campaign = "lot 3", .run = {}})->size(); });
  ask("models of a unit", [&] { return catalog.models(serial)->size(); });
  ask("all models", [&] { return catalog.models()->size(); });
  ask("newest 100 events", [&] {
    db::EventFilter filter;
    filter.most = 100;
    return catalog.find_events(filter)->size();
  });
}

/// Seconds to fit all units of a fresh store.
double fit_seconds(const std::filesystem::path& folder, const StoreSize& size, int jobs) {
  const db::Catalog catalog = made_store(folder, size);
  std::vector<std::string> serials;
  for (int unit = 0; unit < size.units; ++unit) serials.push_back(serial_of(unit));
  const auto start = Clock::now();
  const auto batch = station::fit_batch(catalog, serials, {{}, {}, jobs, "bench"}, [](double) { return true; });
  demand(batch.ended);
  const double seconds = seconds_since(start);
  for (const station::BatchUnit& unit : batch.units) {
    if (unit.failure) demand(tl::unexpected<base::Error>(*unit.failure));
  }
  return seconds;
}

void fit_all(const std::filesystem::path& folder) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  StoreSize size{8, 3, 21};
  fmt::print("fitted: units of {} runs of {} plateaus up and down, six sensors\n", size.runs, size.plateaus);
  const double small_s = fit_seconds(folder, size, 1);
  fmt::print("  {:>4} units on 1 thread   {:>7.2f} s, {:.2f} units/s\n", size.units, small_s, size.units / small_s);
  size.units *= 4;
  const double large_s = fit_seconds(folder, size, 1);
  fmt::print("  {:>4} units on 1 thread   {:>7.2f} s: the time grows with the {:.2f}th power of their number\n",
             size.units, large_s, std::log(large_s / small_s) / std::log(4.0));
  const double wide_s = fit_seconds(folder, size, cores);
  fmt::print("  {:>4} units on {} threads  {:>7.2f} s: {:.0f} % of {} times one thread\n", size.units, cores, wide_s,
             100.0 * large_s / wide_s / cores, cores);
}

}  // namespace
}  // namespace soak

int main(int argc, char** argv) {
  const int units = argc > 1 ? static_cast<int>(soak::base::parse_int(argv[1]).value_or(0)) : 10000;
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("soak-bench-store-{}", ::getpid());
  if (units < 1) {
    fmt::print(stderr, "bench_store [UNITS]: UNITS is a number from 1 (default 10000)\n");
    return 2;
  }
  {
    const auto start = soak::Clock::now();
    const soak::db::Catalog catalog = soak::made_store(folder, {units, 20, 1});
    fmt::print("catalog of {} units and {} runs, made in {:.0f} s; limit {:.0f} ms\n", units, 20 * units,
               soak::seconds_since(start), soak::kLimit_ms);
    soak::ask_all(catalog, soak::serial_of(units / 2));
  }
  soak::fit_all(folder);
  std::filesystem::remove_all(folder);
  return 0;
}
