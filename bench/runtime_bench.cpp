// SPDX-License-Identifier: Apache-2.0
// The deployment runtime against what autopilots evaluate today: a cubic polynomial per sensor, its coefficients in
// memory, the temperature clamped to its range. "ns" is the least processor time per value of many short stretches in
// which peer and runtime take turns. "per_cubic" is the median over these turns of the runtime's time over the peer's
// just before: the quotient of the two least times would compare moments of different clock rates.
//
// Two loops. In turn: a value is asked for when the one before is there, as in a control loop or on a processor that
// executes in order; the limits of the project (table <= 2, whole exponents <= 4, general bells <= 20) are for this
// one. Streamed: nothing waits, so that a large processor works at many samples at once; of a cubic, more of them.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <string>
#include <vector>

#include "anfis/model/one_input.h"
#include "base/statistics.h"
#include "calib/deploy/calibration_file.h"
#include "calib/deploy/table_form.h"
#include "calib/runtime/soak_history.h"

namespace soak::calib {
namespace {

constexpr int kRules = 5;
constexpr int kPoints = 256;
constexpr std::size_t kTemperatures = 1024;
constexpr int kStretches = 400;

double now_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

/// As a fit of a thermal curve gives it: rules that overlap. slope 0: Gaussians.
Curve model(int rules, double slope) {
  std::vector<anfis::CurveRule> list;
  const double spacing = 2.0 / (rules - 1);
  for (int k = 0; k < rules; ++k) {
    list.push_back({0.6 * spacing, slope, -1.0 + spacing * k, 0.3 * k - 0.5, 0.2 * k - 0.1 * k * k});
  }
  anfis::Model result = anfis::curve_model(slope > 0.0 ? anfis::Shape::bell : anfis::Shape::gaussian, list);
  result.inputs[0].scale = {20.0, 50.0};
  result.inputs[0].min = -30.0;
  result.inputs[0].max = 70.0;
  result.output = {0.01, 0.004};
  return result;
}

/// Four cubic pieces.
Curve spline() {
  SplineCurve curve;
  curve.knots_c = {-30.0, -5.0, 20.0, 45.0, 70.0};
  for (int piece = 0; piece < 4; ++piece) curve.coefficients.push_back({1e-3 * piece, 4e-5, -1e-6, 3e-8});
  return curve;
}

/// All six sensors with this bias curve.
Calibration with(const Curve& curve) {
  Calibration calibration;
  calibration.unit = "bench";
  for (const Sensor sensor : kSensors) {
    SensorCalibration one;
    one.sensor = sensor;
    one.temp_min_c = -30.0;
    one.temp_max_c = 70.0;
    one.bias = curve;
    calibration.sensors.push_back(one);
  }
  return calibration;
}

/// Temperatures of the valid range in no order.
std::vector<float> temperatures() {
  std::vector<float> temps;
  for (std::size_t i = 0; i < kTemperatures; ++i) {
    temps.push_back(-28.0F + 96.0F * static_cast<float>(i * 37 % kTemperatures) / static_cast<float>(kTemperatures));
  }
  return temps;
}

struct Cubic {
  float min_c, max_c, reference_c, c[4];
};

float value_of(const Cubic& cubic, float temp_c) {
  const float d = soak_clamp(temp_c, cubic.min_c, cubic.max_c) - cubic.reference_c;
  return cubic.c[0] + d * (cubic.c[1] + d * (cubic.c[2] + d * cubic.c[3]));
}

float value_of(const soak_cal& cal, float temp_c) {
  float value = 0.0F;
  return soak_bias(&cal, SOAK_GYRO_X, temp_c, &value) == SOAK_OK ? value : 0.0F;
}

/// Nanoseconds per value of one stretch; in_turn: each temperature waits for the value before (which it hardly
/// changes).
template <class Source>
double stretch_ns(const Source& source, const std::vector<float>& temps, bool in_turn) {
  float value = 0.0F;
  const double start = now_ns();
  for (const float temp_c : temps) {
    benchmark::ClobberMemory();
    value = value_of(source, in_turn ? temp_c + value : temp_c);
    benchmark::DoNotOptimize(value);
  }
  return (now_ns() - start) / static_cast<double>(temps.size());
}

void compare(benchmark::State& state, const Calibration& calibration, bool in_turn) {
  const auto bytes = encode(calibration);
  soak_cal cal;
  if (!bytes || soak_load(&cal, bytes->data(), bytes->size()) != SOAK_OK) return state.SkipWithError("no file");
  Cubic cubic{-30.0F, 70.0F, 25.0F, {0.01F, 1e-4F, 1e-6F, 1e-8F}};
  benchmark::DoNotOptimize(&cubic);
  benchmark::DoNotOptimize(&cal);
  const std::vector<float> temps = temperatures();
  std::vector<double> own_ns;
  std::vector<double> cubic_ns;
  std::vector<double> ratio;
  for (auto _ : state) {
    for (int i = 0; i < kStretches; ++i) {
      cubic_ns.push_back(stretch_ns(cubic, temps, in_turn));
      own_ns.push_back(stretch_ns(cal, temps, in_turn));
      ratio.push_back(own_ns.back() / cubic_ns.back());
    }
  }
  state.counters["ns"] = *std::min_element(own_ns.begin(), own_ns.end());
  state.counters["cubic_ns"] = *std::min_element(cubic_ns.begin(), cubic_ns.end());
  state.counters["per_cubic"] = base::median(ratio);
}

const char* loop_name(const benchmark::State& state) { return state.range(0) != 0 ? "in turn" : "streamed"; }

void Table(benchmark::State& state) {
  state.SetLabel(loop_name(state));
  compare(state, *table_form(with(model(kRules, 1.7)), kPoints), state.range(0) != 0);
}

void WholeExponents(benchmark::State& state) {
  state.SetLabel(loop_name(state));
  compare(state, with(model(kRules, 2.0)), state.range(0) != 0);
}

void GeneralBells(benchmark::State& state) {
  state.SetLabel(loop_name(state));
  compare(state, with(model(kRules, 1.7)), state.range(0) != 0);
}

void Gaussians(benchmark::State& state) {
  state.SetLabel(loop_name(state));
  compare(state, with(model(kRules, 0.0)), state.range(0) != 0);
}

/// A whole sample of six sensors with nine rules each, the most that a fit of ours has chosen so far.
void Sample(benchmark::State& state) {
  const Curve curve = model(9, state.range(0) != 0 ? 1.7 : 0.0);
  state.SetLabel(state.range(0) != 0 ? "general bells" : "Gaussians");
  const auto bytes = encode(with(curve));
  soak_cal cal;
  if (!bytes || soak_load(&cal, bytes->data(), bytes->size()) != SOAK_OK) return state.SkipWithError("no file");
  const std::vector<float> temps = temperatures();
  const float raw[6] = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  for (auto _ : state) {
    for (const float temp_c : temps) {
      float out[6];
      std::uint32_t flags = 0;
      const soak_status status = soak_apply(&cal, temp_c, raw, out, &flags);
      benchmark::DoNotOptimize(status);
      benchmark::DoNotOptimize(out);
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(temps.size()));
}

/// The forms of a curve that a file can have, and what they are called here.
constexpr std::array<const char*, 5> kForms = {"table", "cubic spline", "whole exponents", "Gaussians",
                                               "general bells"};

/// All six sensors with a curve of this form.
Calibration of_form(std::size_t form) {
  switch (form) {
    case 0:
      return *table_form(with(model(kRules, 1.7)), kPoints);
    case 1:
      return with(spline());
    case 2:
      return with(model(kRules, 2.0));
    case 3:
      return with(model(kRules, 0.0));
    default:
      return with(model(kRules, 1.7));
  }
}

/// Which sensors remember, over how many widths, and at how many set points their curves hold a mean.
struct Remembering {
  const char* name;
  std::size_t sensors;
  double wider_c;  ///< the width of each sensor than that of the one before; 0: one width
  int set_points;  ///< from -30 to 70 degC
};
constexpr std::array<Remembering, 4> kRemembering = {{{"three gyros, one width, 21 set points", 3, 0.0, 21},
                                                      {"three gyros, three widths, 21 set points", 3, 3.0, 21},
                                                      {"six sensors, six widths, 21 set points", 6, 3.0, 21},
                                                      {"six sensors, six widths, 101 set points", 6, 3.0, 101}}};

/// Curves of this form, and a thermal history.
Calibration with_history(std::size_t form, const Remembering& remembering) {
  Calibration calibration = of_form(form);
  for (std::size_t s = 0; s < remembering.sensors; ++s) {
    const Sensor sensor = kSensors.at(s);
    const double width_c = 6.0 + remembering.wider_c * static_cast<double>(s);
    AcceptedTerm term{"thermal_hysteresis", false, {sensor}, {{"amplitude", 0.01}, {"width_c", width_c}}};
    const double apart_c = 100.0 / (remembering.set_points - 1);
    for (int k = 1; k <= remembering.set_points; ++k) {
      term.parameters.emplace_back("mean_" + std::to_string(k) + "_c", -30.0 + apart_c * (k - 1));
      term.parameters.emplace_back("mean_" + std::to_string(k), 1e-4 * k);
    }
    calibration.terms.push_back(term);
  }
  return calibration;
}

/// Each sample comes with a reading of the thermometer that moves the rod: the dearest case. "per_plain" is the median
/// over turns of its time over that of soak_apply just before, with curves of the same form; the limit is 2 for each
/// form.
void History(benchmark::State& state) {
  const auto form = static_cast<std::size_t>(state.range(0));
  const Remembering& remembering = kRemembering.at(static_cast<std::size_t>(state.range(1)));
  state.SetLabel(std::string(kForms.at(form)) + "; " + remembering.name + "; limit 2");
  const auto bytes = encode(with_history(form, remembering));
  soak_cal cal;
  soak_history history;
  if (!bytes || soak_load(&cal, bytes->data(), bytes->size()) != SOAK_OK ||
      soak_load_history(&history, &cal) != SOAK_OK) {
    return state.SkipWithError("no file");
  }
  const std::vector<float> temps = temperatures();
  const float raw[6] = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
  const auto time_of = [&](auto apply) {
    const double start = now_ns();
    for (const float temp_c : temps) {
      float out[6];
      std::uint32_t flags = 0;
      const soak_status status = apply(temp_c, out, &flags);
      benchmark::DoNotOptimize(status);
      benchmark::DoNotOptimize(out);
    }
    return (now_ns() - start) / static_cast<double>(temps.size());
  };
  std::vector<double> ratio;
  std::vector<double> own_ns;
  for (auto _ : state) {
    for (int i = 0; i < kStretches; ++i) {
      const double plain_ns = time_of(
          [&](float temp_c, float* out, std::uint32_t* flags) { return soak_apply(&cal, temp_c, raw, out, flags); });
      own_ns.push_back(time_of([&](float temp_c, float* out, std::uint32_t* flags) {
        (void)soak_history_step(&history, temp_c);
        return soak_apply_history(&cal, nullptr, &history, temp_c, 0.0F, raw, out, flags);
      }));
      ratio.push_back(own_ns.back() / plain_ns);
    }
  }
  state.counters["ns"] = *std::min_element(own_ns.begin(), own_ns.end());
  state.counters["per_plain"] = base::median(ratio);
}

BENCHMARK(Table)->ArgName("in_turn")->Arg(1)->Arg(0)->Iterations(1);
BENCHMARK(WholeExponents)->ArgName("in_turn")->Arg(1)->Arg(0)->Iterations(1);
BENCHMARK(GeneralBells)->ArgName("in_turn")->Arg(1)->Arg(0)->Iterations(1);
BENCHMARK(Gaussians)->ArgName("in_turn")->Arg(1)->Arg(0)->Iterations(1);
BENCHMARK(Sample)->ArgName("bells")->Arg(1)->Arg(0)->Unit(benchmark::kMicrosecond);
BENCHMARK(History)
    ->ArgNames({"form", "remembering"})
    ->ArgsProduct({benchmark::CreateDenseRange(0, kForms.size() - 1, 1),
                   benchmark::CreateDenseRange(0, kRemembering.size() - 1, 1)})
    ->Iterations(1);

}  // namespace
}  // namespace soak::calib
