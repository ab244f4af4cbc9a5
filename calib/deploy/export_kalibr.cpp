// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export_kalibr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/text.h"
#include "calib/deploy/detail/comment.h"
#include "calib/signal/allan/allan.h"

namespace soak::calib {
namespace {

using exporting::comment;
using signal::AllanCoefficient;

constexpr std::size_t kPerDecade = 12;
constexpr double kDoubtfulFit = 0.001;

/// A coefficient of AxisNoise, as the file and its comments name it.
struct Term {
  AllanCoefficient AxisNoise::* coefficient;
  const char* key;
  const char* gyro_unit;
  const char* accel_unit;
};
constexpr std::array<Term, 2> kTerms = {
    {{&AxisNoise::density, "noise_density", "rad/s/sqrt(Hz)", "m/s^2/sqrt(Hz)"},
     {&AxisNoise::random_walk, "random_walk", "rad/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)"}}};

AllanCoefficient scaled(AllanCoefficient coefficient, double factor) {
  coefficient.value *= factor;
  coefficient.low *= factor;
  coefficient.high *= factor;
  return coefficient;
}

double written(const AllanCoefficient& coefficient) { return coefficient.found ? coefficient.value : coefficient.high; }

KalibrValue worst_of(const Term& term, bool gyro, std::span<const AxisNoise> noise) {
  KalibrValue worst;
  worst.key = fmt::format("{}_{}", gyro ? "gyroscope" : "accelerometer", term.key);
  worst.value = -1.0;
  for (const AxisNoise& axis : noise) {
    const AllanCoefficient& coefficient = axis.*term.coefficient;
    if (is_gyro(axis.sensor) != gyro || !(written(coefficient) > worst.value)) continue;
    worst.value = written(coefficient);
    worst.worst = axis.sensor;
    worst.bound = !coefficient.found;
  }
  return worst;
}

std::string axis_comment(const Term& term, const AxisNoise& axis) {
  const AllanCoefficient& coefficient = axis.*term.coefficient;
  std::string text =
      coefficient.found ? fmt::format("  {}: {:.3e}, 95 % interval {:.3e} to {:.3e}", name_of(axis.sensor),
                                      coefficient.value, coefficient.low, coefficient.high)
                        : fmt::format("  {}: not found, at most {:.3e} (95 %)", name_of(axis.sensor), coefficient.high);
  if (axis.p_value < kDoubtfulFit) text += fmt::format("; poor fit, p = {:.1e}", axis.p_value);
  return comment(text);
}

std::string value_text(const Term& term, const KalibrValue& value, std::span<const AxisNoise> noise) {
  const bool gyro = is_gyro(value.worst);
  std::string text = comment(
      fmt::format("{} in {}, worst axis {}", value.key, gyro ? term.gyro_unit : term.accel_unit, name_of(value.worst)));
  for (const AxisNoise& axis : noise) {
    if (is_gyro(axis.sensor) == gyro) text += axis_comment(term, axis);
  }
  if (value.bound) {
    text += comment(
        "  UPPER BOUND, not a measurement: the record shows no such noise; kalibr wants a value above 0, so this is");
    text += comment(
        "  the most that could have stayed hidden (upper end of the 95 % interval). A longer record lowers it.");
  }
  return text + fmt::format("{}: {:.6e}\n", value.key, value.value);
}

std::string provenance(const KalibrSource& source, std::span<const AxisNoise> noise) {
  const AxisNoise& first = noise.front();
  std::string text;
  if (source.simulated) text += comment("SIMULATED SIMULATED SIMULATED: made from simulated data.");
  text += comment("Noise by Soak for kalibr (docs/deployment.md), from the Allan deviation at rest.");
  text += comment("unit: " + source.unit);
  text += comment("unit type: " + source.unit_type);
  text += comment("run: " + source.run + ", " + source.content_sha256);
  text += comment("recorded: " + base::utc_text(source.recorded_utc_s));
  text += comment("created: " + base::utc_text(source.created_utc_s));
  text += comment(fmt::format(
      "at rest: position {}, unit at {:.1f} degC ({:.1f} to {:.1f}); other temperatures may be noisier",
      source.position.empty() ? "not known" : source.position, source.temp_c, source.least_temp_c, source.most_temp_c));
  if (source.most_temp_c - source.least_temp_c > kKalibrMostSwing_k) {
    text +=
        comment(fmt::format("TEMPERATURE NOT CONSTANT, it swings by {:.1f} K: drift with it passes for random walk. "
                            "Record at rest at one temperature.",
                            source.most_temp_c - source.least_temp_c));
  }
  text += comment(fmt::format("longest averaging time: {:.0f} s", first.longest_tau_s));
  for (const AxisNoise& axis : noise) {
    const std::optional<double> corner_hz = axis.low_pass ? axis.low_pass->half_power_hz() : std::nullopt;
    if (!corner_hz) continue;
    text += comment(
        fmt::format("{}: low-pass of {:.3g} Hz; the density is that well below it", name_of(axis.sensor), *corner_hz));
  }
  text +=
      comment("Flicker and drift with temperature are in neither value; many users raise both by a factor for that.");
  return text;
}

}  // namespace

base::Result<AxisNoise> axis_noise(Sensor sensor, const SignalRecord& record) {
  const std::string place(name_of(sensor));
  const auto phase = signal::PhaseRecord::from_rate(record.values, record.rate_hz);
  if (!phase) return base::bad_input(phase.error().message, place);
  // The last two thirds of the possible averaging times rest on a difference or two.
  const std::size_t longest = std::max<std::size_t>(1, 2 * phase->longest(signal::AllanKind::overlapping) / 3);
  const double longest_tau_s = static_cast<double>(longest) * phase->interval_s();
  if (longest_tau_s < kKalibrLeastStill_s / 3.0 * 0.99) {
    return base::bad_input(fmt::format("the longest stretch at rest without a gap carries averaging times of up to "
                                       "{:.3g} s, and {:g} s are needed: record {:g} minutes or more in one position "
                                       "at a constant temperature (procedures/static-allan.toml)",
                                       longest_tau_s, kKalibrLeastStill_s / 3.0, kKalibrLeastStill_s / 60.0),
                           place);
  }
  signal::AllanCurve curve = signal::overlapping_curve(*phase, signal::log_spaced_multiples(longest, kPerDecade));
  curve.low_pass = signal::find_low_pass(record.values, record.rate_hz);
  const auto fit = signal::fit_allan(curve);
  if (!fit) return base::bad_input("no noise terms: " + fit.error().message, place);
  const double si_per_printed = 1.0 / printed_per_si(sensor);
  return AxisNoise{sensor,
                   scaled(fit->angle_random_walk, si_per_printed),
                   scaled(fit->rate_random_walk, si_per_printed),
                   record.rate_hz,
                   longest_tau_s,
                   fit->p_value,
                   curve.low_pass};
}

base::Result<KalibrFile> export_kalibr(const KalibrSource& source, std::span<const AxisNoise> noise) {
  for (const bool gyro : {false, true}) {
    const bool has =
        std::any_of(noise.begin(), noise.end(), [&](const AxisNoise& axis) { return is_gyro(axis.sensor) == gyro; });
    if (has) continue;
    return base::bad_input(
        fmt::format("the run has no {}, and kalibr wants the noise of both kinds", gyro ? "gyro" : "accelerometer"),
        source.run);
  }
  KalibrFile file;
  file.text = provenance(source, noise) + "rostopic: /imu0  # put yours here\n" +
              fmt::format("update_rate: {:.6f}  # Hz\n", noise.front().rate_hz);
  std::size_t n = 0;
  for (const bool gyro : {false, true}) {
    for (const Term& term : kTerms) {
      const KalibrValue value = worst_of(term, gyro, noise);
      if (!std::isfinite(value.value) || !(value.value > 0.0)) {
        return base::bad_input(
            fmt::format("{} is {:g}, and kalibr wants a finite value above 0: record longer", value.key, value.value),
            source.run);
      }
      file.text += value_text(term, value, noise);
      file.values[n++] = value;
    }
  }
  return file;
}

}  // namespace soak::calib
