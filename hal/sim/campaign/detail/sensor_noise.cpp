// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/detail/sensor_noise.h"

#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

constexpr std::uint64_t kMaxSlowProcesses = 1 << 16;

}  // namespace

double mean_variance_of_gauss_markov(double correlation_time_s, double interval_s, int count) {
  double sum = count;
  for (int lag = 1; lag < count; ++lag) sum += 2.0 * (count - lag) * std::exp(-lag * interval_s / correlation_time_s);
  return sum / (static_cast<double>(count) * count);
}

SensorNoise::SensorNoise(const CampaignConfig& config, calib::Sensor sensor, std::uint64_t run_seed)
    : run_seed_(run_seed), sensor_index_(calib::index_of(sensor)) {
  const double sigma = config.magnitudes(sensor).segment_mean_sigma;
  white_sigma_ = sigma * std::sqrt((1.0 - config.noise.slow_share) * config.rows_per_position);
  double slow_mean_variance = 0.0;
  for (const double time_s : config.noise.slow_correlation_times_s) {
    slow_.push_back({time_s});
    slow_mean_variance += mean_variance_of_gauss_markov(time_s, config.row_interval_s, config.rows_per_position);
  }
  slow_sigma_ = sigma * std::sqrt(config.noise.slow_share / slow_mean_variance);
}

double SensorNoise::at(std::uint64_t index, double t_s) {
  const std::uint64_t white_stream = stream_of(Purpose::white_noise, sensor_index_);
  double noise = white_sigma_ * base::hashed_gaussian(run_seed_, white_stream, index);
  for (std::size_t i = 0; i < slow_.size(); ++i) {
    Process& process = slow_[i];
    const std::uint64_t stream = stream_of(Purpose::slow_noise, sensor_index_ * kMaxSlowProcesses + i);
    const double decay = started_ ? std::exp(-(t_s - last_t_s_) / process.correlation_time_s) : 0.0;
    const double innovation = base::hashed_gaussian(run_seed_, stream, index);
    process.state = decay * process.state + std::sqrt(1.0 - decay * decay) * innovation;
    noise += slow_sigma_ * process.state;
  }
  last_t_s_ = t_s;
  started_ = true;
  return noise;
}

}  // namespace soak::hal::sim
