// SPDX-License-Identifier: Apache-2.0
// Kinematic spectra, sections 4.1 and 4.2 of the thesis: what the wavelet prefilter takes off the readings of a
// recorded drive (a drive file as argument), at rest and while driving, in the band of the vehicle's motion and above.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/signal/spectrum/spectrum.h"
#include "calib/vocabulary/sensor.h"
#include "nav/filter/alignment.h"
#include "nav/prefilter/wmra_pipeline.h"
#include "station/nav/drive_file.h"

namespace soak::station {
namespace {

using calib::signal::Spectrum;
using Samples = std::vector<nav::ImuSample>;

/// Of readings, what is slower than 0.1 Hz is not looked at: a rest of half a minute has several such sections.
constexpr double kSection_s = 10.0;
/// Of the truth: what a vehicle does mostly takes longer than 10 s.
constexpr double kTruthSection_s = 64.0;
constexpr double kDriving_mps = 3.0;
/// Of the power of the vehicle's horizontal acceleration, below the end of its band.
constexpr double kMotionShare = 0.95;

Spectrum spectrum_of(const std::vector<double>& values, double rate_hz, double section_s) {
  calib::signal::WelchOptions options;
  options.section = static_cast<std::size_t>(section_s * rate_hz);
  return calib::signal::welch(values, rate_hz, options).value();
}

double power_between(const Spectrum& spectrum, double from_hz, double to_hz) {
  double sum = 0.0;
  for (std::size_t k = 0; k < spectrum.density.size(); ++k) {
    if (spectrum.frequency_hz[k] > from_hz && spectrum.frequency_hz[k] <= to_hz) sum += spectrum.density[k];
  }
  return sum * spectrum.frequency_hz[1];
}

/// Horizontal accelerations by differences of the truth's velocities: east, then north.
std::vector<std::vector<double>> accelerations_mps2(const std::vector<nav::TruthPoint>& truth) {
  std::vector<std::vector<double>> accelerations(2);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Eigen::Vector3d change_mps = truth[i].velocity_mps - truth[i - 1].velocity_mps;
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      accelerations[static_cast<std::size_t>(axis)].push_back(change_mps(axis) / (truth[i].t_s - truth[i - 1].t_s));
    }
  }
  return accelerations;
}

/// Where the band of the vehicle's motion ends. The receiver does not shake with the engine as the unit does; its noise
/// can make the band wider, not narrower.
double motion_until_hz(const std::vector<nav::TruthPoint>& truth) {
  const double rate_hz = static_cast<double>(truth.size() - 1) / (truth.back().t_s - truth.front().t_s);
  std::vector<Spectrum> spectra;
  for (const auto& acceleration : accelerations_mps2(truth))
    spectra.push_back(spectrum_of(acceleration, rate_hz, kTruthSection_s));
  const auto until = [&](double to_hz) {
    double sum = 0.0;
    for (const Spectrum& spectrum : spectra) sum += power_between(spectrum, 0.0, to_hz);
    return sum;
  };
  const auto& bins_hz = spectra.front().frequency_hz;
  return *std::ranges::find_if(
      bins_hz, [&](double to_hz) { return until(to_hz) >= kMotionShare * until(std::numeric_limits<double>::max()); });
}

using State = std::function<bool(double t_s)>;

State driving_in(const nav::Drive& drive) {
  return [&truth = drive.truth](double t_s) {
    const auto next = std::ranges::lower_bound(truth, t_s, {}, &nav::TruthPoint::t_s);
    return next != truth.end() && next->velocity_mps.head<2>().norm() > kDriving_mps;
  };
}

/// Spectrum of a sensor's readings in deg/s or m/s² where the vehicle is in this state.
Spectrum spectrum_in(const Samples& samples, calib::Sensor sensor, const State& state) {
  const auto axis = static_cast<Eigen::Index>(calib::axis_of(sensor));
  std::vector<double> values;
  for (const nav::ImuSample& sample : samples) {
    const double value =
        calib::printed_per_si(sensor) * (calib::is_gyro(sensor) ? sample.rate_rps(axis) : sample.force_mps2(axis));
    values.push_back(state(sample.t_s) ? value : std::numeric_limits<double>::quiet_NaN());
  }
  const double rate_hz = static_cast<double>(samples.size() - 1) / (samples.back().t_s - samples.front().t_s);
  return spectrum_of(values, rate_hz, kSection_s);
}

/// Readings as they were, as the prefilter gives them live, and looking ahead.
struct Readings {
  Samples raw;
  Samples live;
  Samples batch;
};

void print_sensor(const Readings& readings, calib::Sensor sensor, std::string_view name, const State& state,
                  double motion_hz) {
  const Spectrum raw = spectrum_in(readings.raw, sensor, state);
  const Spectrum live = spectrum_in(readings.live, sensor, state);
  const Spectrum batch = spectrum_in(readings.batch, sensor, state);
  fmt::print("  {:<8} {:<8} {:>8}", calib::name_of(sensor), name, raw.sections);
  for (const auto& [from_hz, to_hz] : {std::pair{0.0, motion_hz}, {motion_hz, std::numeric_limits<double>::max()}}) {
    const double before = power_between(raw, from_hz, to_hz);
    const auto removed_percent = [&](const Spectrum& after) {
      return 100.0 * (1.0 - power_between(after, from_hz, to_hz) / before);
    };
    fmt::print(" {:>12.3g} {:>8.1f} {:>8.1f}", before, removed_percent(live), removed_percent(batch));
  }
  fmt::print("\n");
}

int run(const nav::Drive& drive) {
  const double rest_until_s = nav::end_of_rest_s(drive);
  if (rest_until_s - drive.imu.front().t_s < kSection_s) {
    fmt::print(stderr, "{}: the drive must begin with a rest of {} s or more\n", drive.name, kSection_s);
    return 2;
  }
  const auto start = nav::align(drive, {});
  if (!start) {
    fmt::print(stderr, "{}: {}\n", start.error().where, start.error().message);
    return 2;
  }
  const auto known = std::ranges::upper_bound(drive.imu, start->t_s, {}, &nav::ImuSample::t_s) - drive.imu.begin();
  const Readings readings{drive.imu, nav::smoothed_live(drive.imu, static_cast<std::size_t>(known)).value(),
                          nav::smoothed_batch(drive.imu).value()};
  const double motion_hz = motion_until_hz(drive.truth);
  fmt::print(
      "{}: power in (deg/s)² and (m/s²)² from {:.1f} Hz on; the vehicle's motion ends at {:.2f} Hz ({:.0f} % "
      "of its horizontal acceleration's power by the truth)\n",
      drive.name, 1.0 / kSection_s, motion_hz, 100.0 * kMotionShare);
  fmt::print("  {:<8} {:<8} {:>8} {:>12} {:>8} {:>8} {:>12} {:>8} {:>8}\n", "sensor", "vehicle", "sections", "motion",
             "live -%", "batch -%", "above", "live -%", "batch -%");
  for (const calib::Sensor sensor : calib::kSensors) {
    print_sensor(readings, sensor, "rests", [&](double t_s) { return t_s <= rest_until_s; }, motion_hz);
    print_sensor(readings, sensor, "drives", driving_in(drive), motion_hz);
  }
  return 0;
}

}  // namespace
}  // namespace soak::station

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: bench_nav_spectra DRIVE.toml\n");
    return 2;
  }
  const auto drive = soak::station::read_drive(argv[1]);
  if (!drive) {
    fmt::print(stderr, "{}: {}\n", drive.error().where, drive.error().message);
    return 2;
  }
  return soak::station::run(*drive);
}
