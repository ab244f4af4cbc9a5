// SPDX-License-Identifier: Apache-2.0
// Speed of the Allan family on 20 h at 200 Hz: 14.4 million samples, averaging times spaced evenly on a logarithmic
// scale from 1 to a third of the record. The peer is the algorithm as numpy users write it (signal_allan_peer.py), run
// in the same minute on some of the averaging times; each time is the least of several. "per_numpy" is the peer's
// processor time over ours, one thread each: on a machine that others use too, that is what compares.
// "per_numpy_wall" is the same of wall time, also for several threads. "per_read" is our time over that of reading the
// record once from memory. Without numpy the figures of the peer are left out.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/random.h"
#include "calib/signal/allan/allan.h"
#include "calib/signal/allan/allan_stream.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kSamples = 14400000;
constexpr double kRateHz = 200.0;
constexpr double kInputBytes = 8.0 * kSamples;

/// Least times of several runs.
struct Times {
  double wall_ms = 1e9;
  double thread_ms = 1e9;  ///< processor time of the calling thread
};

double now_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
void keep_least(Times& least, Work work) {
  const double wall = now_s(CLOCK_MONOTONIC);
  const double thread = now_s(CLOCK_THREAD_CPUTIME_ID);
  work();
  least.thread_ms = std::min(least.thread_ms, 1e3 * (now_s(CLOCK_THREAD_CPUTIME_ID) - thread));
  least.wall_ms = std::min(least.wall_ms, 1e3 * (now_s(CLOCK_MONOTONIC) - wall));
}

/// A line of /proc/self/status ("VmRSS", "VmHWM": the most so far) in bytes.
double status_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kib = 0.0;
    if (word == name + ":" && status >> kib) return 1024.0 * kib;
  }
  return 0.0;
}

const std::vector<double>& rate() {
  static const std::vector<double> samples = [] {
    std::vector<double> noise(kSamples);
    base::Random random(1);
    for (double& value : noise) value = random.gaussian();
    return noise;
  }();
  return samples;
}

const PhaseRecord& record() {
  static const PhaseRecord phase = *PhaseRecord::from_rate(rate(), kRateHz);
  return phase;
}

/// 60 or a few more.
std::vector<std::size_t> averaging_times() {
  for (std::size_t per_decade = 9;; ++per_decade) {
    std::vector<std::size_t> multiples = log_spaced_multiples(kSamples / 3, per_decade);
    if (multiples.size() >= 60) return multiples;
  }
}

/// Every seventh averaging time: those of the peer.
std::vector<std::size_t> peers_averaging_times() {
  const std::vector<std::size_t> all = averaging_times();
  std::vector<std::size_t> some;
  for (std::size_t k = 3; k < all.size(); k += 7) some.push_back(all[k]);
  return some;
}

/// The peer's times at each of its averaging times; empty without numpy.
const std::map<std::size_t, Times>& numpy_times() {
  static const std::map<std::size_t, Times> times = [] {
    std::string command = "/usr/bin/python3 " SOAK_BENCH_FOLDER "/signal_allan_peer.py " + std::to_string(kSamples);
    for (const std::size_t m : peers_averaging_times()) command += " " + std::to_string(m);
    std::map<std::size_t, Times> measured;
    FILE* peer = popen((command + " 2>/dev/null").c_str(), "r");
    if (peer == nullptr) return measured;
    double wall = 0.0, processor = 0.0, deviation = 0.0;
    for (const std::size_t m : peers_averaging_times()) {
      if (std::fscanf(peer, "%lf %lf %lf", &wall, &processor, &deviation) == 3) {
        measured[m] = {1e3 * wall, 1e3 * processor};
      }
    }
    pclose(peer);
    return measured;
  }();
  return times;
}

/// Mean over its averaging times; 0 without numpy.
Times mean_of_numpy() {
  Times mean{0.0, 0.0};
  const auto count = static_cast<double>(numpy_times().size());
  for (const auto& [m, times] : numpy_times()) {
    mean.wall_ms += times.wall_ms / count;
    mean.thread_ms += times.thread_ms / count;
  }
  return mean;
}

/// Reads the record once, 16 sums side by side.
double read_ms() {
  static const double least = [] {
    Times times;
    for (int i = 0; i < 10; ++i) {
      keep_least(times, [] {
        const std::span<const double> x = record().phase();
        double sums[16] = {};
        for (std::size_t k = 0; k + 16 <= x.size(); k += 16) {
          for (std::size_t lane = 0; lane < 16; ++lane) sums[lane] += x[k + lane];
        }
        benchmark::DoNotOptimize(sums);
      });
    }
    return times.thread_ms;
  }();
  return least;
}

/// `each`: our times per averaging time; `threads` that shared the work.
void report(benchmark::State& state, Times each, std::int64_t threads, Times numpy) {
  state.counters["wall_ms_each"] = each.wall_ms;
  if (threads == 1) state.counters["ms_each"] = each.thread_ms;
  if (threads == 1) state.counters["per_read"] = each.thread_ms / read_ms();
  if (numpy.wall_ms == 0.0) return;
  state.counters["numpy_wall_ms"] = numpy.wall_ms;
  state.counters["numpy_ms"] = numpy.thread_ms;
  state.counters["per_numpy_wall"] = numpy.wall_ms / each.wall_ms;
  if (threads == 1) state.counters["per_numpy"] = numpy.thread_ms / each.thread_ms;
}

/// Phase from rate; "peak_per_input" is the most memory of the process so far, the input among it, over the input's.
/// Registered first: nothing else has been in memory.
void Phase(benchmark::State& state) {
  benchmark::DoNotOptimize(rate().data());
  for (auto _ : state) benchmark::DoNotOptimize(record().phase().data());
  state.counters["peak_per_input"] = status_bytes("VmHWM") / kInputBytes;
}
BENCHMARK(Phase)->Unit(benchmark::kMillisecond)->Iterations(1);

/// The averaging times are dealt out to the threads like cards.
void AllAveragingTimes(benchmark::State& state, AllanKind kind) {
  const std::vector<std::size_t> multiples = averaging_times();
  std::vector<std::vector<std::size_t>> hands(static_cast<std::size_t>(state.range(0)));
  for (std::size_t k = 0; k < multiples.size(); ++k) hands[k % hands.size()].push_back(multiples[k]);
  const auto work = [&](const std::vector<std::size_t>& hand) {
    benchmark::DoNotOptimize(allan_points(record(), kind, hand));
  };
  Times least;
  for (auto _ : state) {
    keep_least(least, [&] {
      std::vector<std::thread> others;
      for (std::size_t k = 1; k < hands.size(); ++k) others.emplace_back(work, std::cref(hands[k]));
      work(hands[0]);
      for (std::thread& other : others) other.join();
    });
  }
  const auto count = static_cast<double>(multiples.size());
  state.counters["averaging_times"] = count;
  report(state, {least.wall_ms / count, least.thread_ms / count}, state.range(0),
         kind == AllanKind::overlapping ? mean_of_numpy() : Times{0.0, 0.0});
  state.counters["peak_per_input"] = status_bytes("VmHWM") / kInputBytes;
}
BENCHMARK_CAPTURE(AllAveragingTimes, overlapping, AllanKind::overlapping)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(10);
BENCHMARK_CAPTURE(AllAveragingTimes, overlapping_hadamard, AllanKind::overlapping_hadamard)
    ->ArgName("threads")
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(3);
BENCHMARK_CAPTURE(AllAveragingTimes, modified, AllanKind::modified)
    ->ArgName("threads")
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(3);

/// One averaging time alone: no other shares the cache with it.
void OneAveragingTime(benchmark::State& state) {
  const auto m = static_cast<std::size_t>(state.range(0));
  Times least;
  for (auto _ : state) {
    keep_least(least, [&] { benchmark::DoNotOptimize(allan_point(record(), AllanKind::overlapping, m)); });
  }
  const auto numpy = numpy_times().find(m);
  report(state, least, 1, numpy == numpy_times().end() ? Times{0.0, 0.0} : numpy->second);
}

void each_of_the_peers(benchmark::internal::Benchmark* benchmark) {
  for (const std::size_t m : peers_averaging_times()) benchmark->Arg(static_cast<std::int64_t>(m));
}
BENCHMARK(OneAveragingTime)
    ->ArgName("multiple")
    ->Apply(each_of_the_peers)
    ->Unit(benchmark::kMillisecond)
    ->Iterations(5);

/// One pass: all averaging times of the stream, all three deviations, in pieces of a second. "memory_mb" is the growth
/// of the process.
void Stream(benchmark::State& state) {
  const std::vector<double>& samples = rate();
  Times least;
  std::size_t averaging_times = 0;
  const double before = status_bytes("VmRSS");
  for (auto _ : state) {
    AllanStream stream = *AllanStream::create(kRateHz);
    keep_least(least, [&] {
      for (std::size_t i = 0; i < samples.size(); i += 200) {
        benchmark::DoNotOptimize(stream.push(std::span(samples).subspan(i, 200)));
      }
      averaging_times = stream.points().size();
    });
    state.counters["memory_mb"] = (status_bytes("VmRSS") - before) / 1e6;
  }
  state.counters["ms"] = least.thread_ms;
  state.counters["averaging_times"] = static_cast<double>(averaging_times);
  state.counters["ns_per_sample"] = 1e6 * least.thread_ms / static_cast<double>(kSamples);
}
BENCHMARK(Stream)->Unit(benchmark::kMillisecond)->Iterations(3);

}  // namespace
}  // namespace soak::calib::signal
