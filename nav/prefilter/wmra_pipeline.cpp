// SPDX-License-Identifier: Apache-2.0
#include "nav/prefilter/wmra_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

#include "calib/signal/wavelet/denoising.h"
#include "calib/signal/wavelet/streaming_denoiser.h"
#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

using calib::signal::Denoised;
using calib::signal::StreamingDenoiser;
using Samples = std::vector<ImuSample>;

constexpr std::size_t kLevels = 3;
constexpr std::string_view kWavelet = "db8";

/// The reading of a sensor, gyros first.
double& reading(ImuSample& sample, Eigen::Index sensor) {
  return sensor < 3 ? sample.rate_rps(sensor) : sample.force_mps2(sensor - 3);
}

/// The samples with what `filter` makes of each sensor's readings in their place.
base::Result<Samples> filtered(
    Samples samples, const std::function<base::Result<std::vector<double>>(const std::vector<double>&)>& filter) {
  for (Eigen::Index sensor = 0; sensor < 6; ++sensor) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (ImuSample& sample : samples) values.push_back(reading(sample, sensor));
    const auto smooth = filter(values);
    if (!smooth) return base::forward_error(smooth);
    for (std::size_t i = 0; i < samples.size(); ++i) reading(samples[i], sensor) = (*smooth)[i];
  }
  return samples;
}

base::Result<Denoised> denoised(std::span<const double> values) {
  const auto wavelet = calib::signal::wavelet_named(kWavelet);
  if (!wavelet) return base::forward_error(wavelet);
  calib::signal::DenoisingOptions options;
  options.levels = kLevels;
  options.noise = calib::signal::NoiseFrom::per_level;
  return calib::signal::denoise(values, *wavelet, options);
}

base::Result<StreamingDenoiser> stream_with(std::span<const double> thresholds) {
  const auto wavelet = calib::signal::wavelet_named(kWavelet);
  if (!wavelet) return base::forward_error(wavelet);
  return StreamingDenoiser::create(*wavelet, calib::signal::Shrinkage::soft, thresholds);
}

/// Thresholds from the first `known` values, then all values as they come out of a stream.
base::Result<std::vector<double>> streamed(const std::vector<double>& values, std::size_t known) {
  const auto before = denoised(std::span(values).first(known));
  if (!before) return base::forward_error(before);
  auto denoiser = stream_with(before->thresholds);
  if (!denoiser) return base::forward_error(denoiser);
  calib::signal::StreamedSamples out;
  if (auto status = denoiser->push(values, out); !status) return base::forward_error(status);
  denoiser->flush(out);
  return std::move(out.signal);
}

/// Time up to which samples are final at `t_s`, of a stream that keeps `latency` samples inside.
double final_until_s(const Samples& samples, double t_s, std::size_t latency) {
  const auto come =
      static_cast<std::size_t>(std::ranges::upper_bound(samples, t_s, {}, &ImuSample::t_s) - samples.begin());
  return come > latency ? samples[come - 1 - latency].t_s : samples.front().t_s;
}

base::Result<std::vector<Solution>> solve_live(const FilterPipeline& parts, const Drive& seen,
                                               std::span<const double> t_s) {
  const auto setup = set_up(parts, seen);
  if (!setup) return base::forward_error(setup);
  const auto any_stream = stream_with(std::vector<double>(kLevels, 0.0));
  if (!any_stream) return base::forward_error(any_stream);
  const std::size_t latency = any_stream->latency();
  const auto known = static_cast<std::size_t>(
      std::ranges::upper_bound(setup->drive.imu, setup->start.t_s, {}, &ImuSample::t_s) - setup->drive.imu.begin());
  if (known < latency) {
    return base::bad_input(
        fmt::format("{} samples lie before the filter's start; wavelets need {} to know the noise", known, latency),
        seen.name);
  }
  auto readings = smoothed_live(setup->drive.imu, known);
  if (!readings) return base::forward_error(readings);
  Drive smooth = setup->drive;
  smooth.imu = *std::move(readings);
  FilterRun run(smooth, setup->start, setup->options);
  std::vector<Solution> solutions;
  for (const double wanted_s : t_s) {
    run.advance_to(std::max(run.now_s(), final_until_s(smooth.imu, wanted_s, latency)));
    FilterRun ahead(run, setup->drive);
    ahead.advance_to(wanted_s);
    solutions.push_back({ahead.filter().antenna(), ahead.filter().antenna_velocity_mps()});
  }
  return solutions;
}

base::Result<std::vector<Solution>> solve_batch(const FilterPipeline& parts, const Drive& seen,
                                                std::span<const double> t_s) {
  auto readings = smoothed_batch(seen.imu);
  if (!readings) return base::forward_error(readings);
  Drive smooth = seen;
  smooth.imu = *std::move(readings);
  return filter_pipeline(parts).solve(smooth, t_s);
}

}  // namespace

base::Result<std::vector<ImuSample>> smoothed_live(std::vector<ImuSample> samples, std::size_t known) {
  return filtered(std::move(samples), [&](const std::vector<double>& values) { return streamed(values, known); });
}

base::Result<std::vector<ImuSample>> smoothed_batch(std::vector<ImuSample> samples) {
  return filtered(std::move(samples), [](const std::vector<double>& values) -> base::Result<std::vector<double>> {
    auto result = denoised(values);
    if (!result) return base::forward_error(result);
    return std::move(result->signal);
  });
}

Pipeline wmra(FilterPipeline filter) {
  return {"wmra", "readings through wavelets as it could run live: no later sample is used; the same filter",
          [filter = std::move(filter)](const Drive& seen, std::span<const double> t_s) {
            return solve_live(filter, seen, t_s);
          }};
}

Pipeline wmra_batch(FilterPipeline filter) {
  return {"wmra_batch", "LOOKS AHEAD: readings of the whole recording through wavelets at once; the same filter",
          [filter = std::move(filter)](const Drive& seen, std::span<const double> t_s) {
            return solve_batch(filter, seen, t_s);
          }};
}

}  // namespace soak::nav
