// SPDX-License-Identifier: Apache-2.0
#include "station/nav/outage_batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <string_view>
#include <thread>

#include "calib/runtime/soak_runtime.h"
#include "calib/vocabulary/sensor.h"
#include "nav/learned/anfis_pipeline.h"
#include "nav/prefilter/wmra_pipeline.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

constexpr auto kWatchEvery = std::chrono::milliseconds(50);

/// A calibration file in memory with the runtime's view of it.
struct Device {
  base::Bytes file;
  soak_cal runtime{};
};

void correct(const Device& device, nav::ImuSample& sample) {
  if (std::isnan(sample.temp_c)) return;
  float raw[calib::kSensorCount];
  float out[calib::kSensorCount];
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    raw[axis] = static_cast<float>(sample.rate_rps(axis));
    raw[axis + 3] = static_cast<float>(sample.force_mps2(axis));
  }
  std::uint32_t flags = 0;
  const soak_status status = soak_apply(&device.runtime, static_cast<float>(sample.temp_c), raw, out, &flags);
  // Above SOAK_OK the output is defined: sensors that the file lacks pass through, the others are corrected.
  if (status < SOAK_OK) return;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    sample.rate_rps(axis) = static_cast<double>(out[axis]);
    sample.force_mps2(axis) = static_cast<double>(out[axis + 3]);
  }
}

/// The sensors that the file does not correct at any temperature.
std::vector<calib::Sensor> raw_sensors(const soak_cal& runtime) {
  constexpr float kAnyTemp_c = 25.0F;
  const float raw[calib::kSensorCount] = {};
  float out[calib::kSensorCount];
  std::uint32_t flags = 0;
  std::vector<calib::Sensor> sensors;
  if (soak_apply(&runtime, kAnyTemp_c, raw, out, &flags) < SOAK_OK)
    return {calib::kSensors.begin(), calib::kSensors.end()};
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::size_t i = calib::index_of(sensor);
    if ((flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U) sensors.push_back(sensor);
  }
  return sensors;
}

bool is_outside(const soak_cal& runtime, double temp_c) {
  if (std::isnan(temp_c)) return false;
  const float raw[calib::kSensorCount] = {};
  float out[calib::kSensorCount];
  std::uint32_t flags = 0;
  if (soak_apply(&runtime, static_cast<float>(temp_c), raw, out, &flags) < SOAK_OK) return false;
  return std::ranges::any_of(calib::kSensors, [flags](calib::Sensor sensor) {
    return (flags & SOAK_FLAG_CLAMPED(calib::index_of(sensor))) != 0U;
  });
}

}  // namespace

base::Result<std::vector<nav::OutageResult>> run_outages(std::span<const nav::Drive> drives,
                                                         std::span<const OutageTask> tasks,
                                                         std::span<const nav::Pipeline> pipelines, int jobs,
                                                         const std::function<bool(double)>& progress) {
  std::vector<std::optional<base::Result<nav::OutageResult>>> results(tasks.size());
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> done = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < tasks.size() && !interrupted(); i = next++) {
      results[i] = nav::run_outage(drives[tasks[i].drive], tasks[i].outage, pipelines);
      ++done;
    }
  };
  const unsigned threads = jobs > 0 ? static_cast<unsigned>(jobs) : std::max(1U, std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> pool;
    for (std::size_t t = 0; t < std::min<std::size_t>(threads, tasks.size()); ++t) pool.emplace_back(work);
    while (done < tasks.size() && !interrupted()) {
      if (!progress(static_cast<double>(done) / static_cast<double>(tasks.size()))) break;
      std::this_thread::sleep_for(kWatchEvery);
    }
  }
  std::vector<nav::OutageResult> all;
  for (auto& result : results) {
    if (!result) return base::fail(base::ErrorKind::internal, "interrupted: nothing was printed");
    if (!*result) return base::forward_error(*result);
    all.push_back(**std::move(result));
  }
  return all;
}

nav::FilterPipeline raw_filter() {
  nav::FilterPipeline raw;
  raw.name = "raw";
  raw.description = "readings as they are; filter of 15 states with noise as is typical of MEMS units";
  raw.filter.sensors = nav::typical_mems();
  return raw;
}

base::Result<nav::ErrorModel> learnt_errors(std::span<const nav::Drive> drives) {
  constexpr double kLength_s = 30.0;
  std::vector<nav::ErrorWindow> windows;
  for (const nav::Drive& drive : drives) {
    const auto setup = nav::set_up(raw_filter(), drive);
    if (!setup) return base::forward_error(setup);
    auto found = nav::error_windows(*setup, nav::successive_begins(*setup, kLength_s, kLength_s), kLength_s);
    std::ranges::move(found, std::back_inserter(windows));
  }
  auto model = nav::learn_errors(windows);
  if (model) return model;
  return base::fail(model.error().kind,
                    fmt::format("{} artificial outages of {} s are what the ANFIS learns from ({}): give it drives of "
                                "ten minutes or more in all, with turns",
                                windows.size(), kLength_s, model.error().message),
                    drives.front().name);
}

bool needs_learning(std::span<const std::string> names) {
  return std::ranges::any_of(names, [](const std::string& name) { return name.starts_with("anfis"); });
}

std::vector<nav::Pipeline> further_pipelines(std::span<const std::string> names,
                                             const std::optional<nav::ErrorModel>& model) {
  std::vector<nav::Pipeline> pipelines;
  for (const std::string_view name : kFurtherPipelines) {
    if (std::ranges::find(names, name) == names.end()) continue;
    if (name == "wmra") pipelines.push_back(nav::wmra(raw_filter()));
    if (name == "wmra_batch") pipelines.push_back(nav::wmra_batch(raw_filter()));
    if (name == "anfis_position") pipelines.push_back(nav::anfis_position(raw_filter(), *model));
    if (name == "anfis_updates") pipelines.push_back(nav::anfis_updates(raw_filter(), *model));
  }
  return pipelines;
}

std::vector<nav::Pipeline> standard_pipelines(const std::optional<nav::Correction>& calibration) {
  const nav::FilterPipeline raw = raw_filter();
  nav::FilterPipeline physics = raw;
  physics.name = "physics";
  physics.description =
      "noise from the Allan deviation at rest, scale factors as states, a vehicle that neither slides nor jumps and is "
      "seen to stand";
  physics.filter.scale_states = true;
  physics.filter.non_holonomic = nav::NonHolonomic{};
  physics.tune_at_rest = true;
  std::vector<nav::Pipeline> pipelines = {nav::filter_pipeline(raw)};
  if (calibration) {
    nav::FilterPipeline calibrated = raw;
    calibrated.name = "calibrated";
    calibrated.description = "readings corrected by the thermal calibration; the same filter";
    calibrated.correction = *calibration;
    pipelines.push_back(nav::filter_pipeline(calibrated));
    physics.correction = *calibration;
    physics.description = "readings corrected by the thermal calibration; " + physics.description;
  }
  pipelines.push_back(nav::filter_pipeline(physics));
  return pipelines;
}

base::Result<DeviceCorrection> device_correction(const base::Bytes& file) {
  const auto device = std::make_shared<Device>();
  device->file = file;
  if (soak_load(&device->runtime, device->file.data(), device->file.size()) != SOAK_OK) {
    return base::corrupt("the deployment runtime cannot load the calibration file");
  }
  DeviceCorrection made{[device](nav::ImuSample& sample) { correct(*device, sample); },
                        [device](double temp_c) { return is_outside(device->runtime, temp_c); },
                        raw_sensors(device->runtime)};
  if (made.raw.size() < calib::kSensorCount) return made;
  return base::bad_input(
      "the calibration file corrects none of the six sensors by the unit's one temperature: a file is needed that "
      "holds "
      "the bias curve of one at least");
}

}  // namespace soak::station
