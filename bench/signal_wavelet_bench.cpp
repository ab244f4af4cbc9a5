// SPDX-License-Identifier: Apache-2.0
// Wavelet denoising of 1.2 million samples, 100 minutes at 200 Hz: db8, level 6, one thread. "least_ms" is the best of
// all repetitions, in processor time because others may use the machine; "memcpys" the time over that of copying the
// signal once, measured in the same run: three, for reading and writing as much in each of the three steps, is the
// bound that memory sets. "times_pywavelets" is how much longer PyWavelets takes, timed alike in the same run where it
// is installed.
#include <benchmark/benchmark.h>
#include <stdio.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/signal/wavelet/denoising.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kSamples = 1200000;
constexpr std::size_t kLevels = 6;
constexpr double kThreshold = 0.5;

double now_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class Work>
double time_ms(Work&& work) {
  const double start = now_ms();
  work();
  return now_ms() - start;
}

template <class Work>
double least_ms(int repetitions, Work&& work) {
  double least = 1e9;
  for (int i = 0; i < repetitions; ++i) least = std::min(least, time_ms(work));
  return least;
}

/// Signal and all memory, used again by every repetition.
struct Task {
  std::vector<double> signal = std::vector<double>(kSamples);
  std::vector<double> back = std::vector<double>(kSamples);
  std::vector<double> scratch;
  Wavelet wavelet = *wavelet_named("db8");
  Boundary boundary;
  Decomposition decomposition;

  explicit Task(Boundary chosen) : boundary(chosen) {
    base::Random random(1);
    for (double& x : signal) x = random.gaussian();
    decompose_all();
  }
  void decompose_all() { benchmark::DoNotOptimize(decompose(signal, wavelet, kLevels, boundary, decomposition)); }
  void shrink_all() {
    for (std::vector<double>& details : decomposition.details) shrink(details, kThreshold, Shrinkage::soft);
  }
  void reconstruct_all() {
    benchmark::DoNotOptimize(reconstruct(decomposition, wavelet, scratch, back));
    benchmark::ClobberMemory();
  }
  void copy() {
    std::memcpy(back.data(), signal.data(), kSamples * sizeof(double));
    benchmark::ClobberMemory();
  }
};

template <class Work>
void measure(benchmark::State& state, Work&& work) {
  Task task(state.range(0) == 0 ? Boundary::symmetric : Boundary::periodization);
  double least = 1e9;
  for (auto _ : state) least = std::min(least, time_ms([&] { work(task); }));
  state.counters["least_ms"] = least;
  state.counters["memcpys"] = least / least_ms(100, [&] { task.copy(); });
}

/// Least time of PyWavelets for the same task, measured once per run; 0 where it is not installed.
double peer_ms() {
  static const double least = [] {
    const std::string command =
        "/usr/bin/python3 " SOAK_BENCH_FOLDER "/signal_wavelet_peer.py " + std::to_string(kSamples) + " 30 2>/dev/null";
    FILE* pipe = popen(command.c_str(), "r");
    char line[64] = "";
    if (pipe == nullptr || fgets(line, sizeof line, pipe) == nullptr) line[0] = '\0';
    if (pipe != nullptr) pclose(pipe);
    return std::atof(line);
  }();
  return least;
}

void Denoise(benchmark::State& state) {
  measure(state, [](Task& task) {
    task.decompose_all();
    task.shrink_all();
    task.reconstruct_all();
  });
  if (peer_ms() == 0.0) return;
  state.counters["pywavelets_ms"] = peer_ms();
  state.counters["times_pywavelets"] = peer_ms() / state.counters["least_ms"];
}
void Decompose(benchmark::State& state) {
  measure(state, [](Task& task) { task.decompose_all(); });
}
void Shrink(benchmark::State& state) {
  measure(state, [](Task& task) { task.shrink_all(); });
}
void Reconstruct(benchmark::State& state) {
  measure(state, [](Task& task) { task.reconstruct_all(); });
}
/// With all memory new, as for a single signal: most of it is the operating system handing out pages.
void DenoiseInNewMemory(benchmark::State& state) {
  measure(state, [](Task& task) {
    task.decomposition = {};
    task.scratch = {};
    task.decompose_all();
    task.shrink_all();
    task.reconstruct_all();
  });
}

#define SOAK_WAVELET_BENCHMARK(name) \
  BENCHMARK(name)->ArgName("periodization")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->Iterations(100)
SOAK_WAVELET_BENCHMARK(Denoise);
SOAK_WAVELET_BENCHMARK(Decompose);
SOAK_WAVELET_BENCHMARK(Shrink);
SOAK_WAVELET_BENCHMARK(Reconstruct);
SOAK_WAVELET_BENCHMARK(DenoiseInNewMemory);

}  // namespace
}  // namespace soak::calib::signal
