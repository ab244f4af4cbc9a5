// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/simulated_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random.h"
#include "hal/sim/unit/attitude.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

constexpr std::uint64_t kMaxSlowProcesses = 1 << 16;

void record_plan(const RunPlan& plan, calib::Recording& recording) {
  recording.positions.assign(plan.positions.begin(), plan.positions.end());
  for (const PlannedRow& row : plan.rows) {
    const SetPoint& set_point = plan.visits[row.visit].set_point;
    recording.t_s.push_back(row.t_s);
    recording.phase.push_back(row.phase);
    recording.sweep.push_back(set_point.sweep);
    recording.plateau_c.push_back(set_point.temp_c);
    recording.position.push_back(row.position);
  }
}

void record_thermometers(const CampaignConfig& config, const RunPlan& plan, const RunTemperature& temperature,
                         std::uint64_t seed, calib::Recording& recording) {
  calib::AuxiliaryChannel chamber{"chamber_c", {}};
  for (std::size_t i = 0; i < plan.rows.size(); ++i) {
    const PlannedRow& row = plan.rows[i];
    const double unit_noise = base::hashed_gaussian(seed, stream_of(Purpose::thermometer), i);
    const double air_noise = base::hashed_gaussian(seed, stream_of(Purpose::chamber), i);
    recording.temp_c.push_back(temperature.unit_c(row.visit, row.t_s) + config.thermometer.noise_sigma_c * unit_noise);
    chamber.values.push_back(temperature.chamber_c(row.visit, row.t_s) + config.chamber.noise_sigma_c * air_noise);
  }
  recording.auxiliary.push_back(std::move(chamber));
}

}  // namespace

RunTemperature::RunTemperature(const CampaignConfig& config, const std::vector<Visit>& visits, std::uint64_t run_seed)
    : thermometer_(config.thermometer), chamber_(config.chamber) {
  base::Random random(run_seed, stream_of(Purpose::visit));
  for (std::size_t i = 0; i < visits.size(); ++i) {
    VisitTemperature visit_state;
    visit_state.visit = visits[i];
    visit_state.settled_c = visits[i].set_point.temp_c + drawn_within(random, thermometer_.visit_offset_half_width_c);
    visit_state.drift_c = drawn_within(random, thermometer_.plateau_drift_half_width_c);
    visit_state.from_c = i == 0 ? visit_state.settled_c : unit_c(i - 1, visits[i].t_change_s);
    visit_state.chamber_from_c = visits[i == 0 ? 0 : i - 1].set_point.temp_c;
    visits_.push_back(visit_state);
  }
}

double RunTemperature::unit_c(std::size_t visit, double t_s) const {
  const VisitTemperature& visit_state = visits_[visit];
  const double to_go = std::exp(-(t_s - visit_state.visit.t_change_s) / thermometer_.settling_time_s);
  const double plateau_s = std::max(visit_state.visit.t_end_s - visit_state.visit.t_soak_s, 1e-9);
  const double passed = std::clamp((t_s - visit_state.visit.t_soak_s) / plateau_s, 0.0, 1.0);
  return visit_state.settled_c + (visit_state.from_c - visit_state.settled_c) * to_go + visit_state.drift_c * passed;
}

double RunTemperature::chamber_c(std::size_t visit, double t_s) const {
  const VisitTemperature& visit_state = visits_[visit];
  const double to_go = std::exp(-(t_s - visit_state.visit.t_change_s) / chamber_.settling_time_s);
  const double set_point_c = visit_state.visit.set_point.temp_c;
  return set_point_c + (visit_state.chamber_from_c - set_point_c) * to_go;
}

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

calib::Recording simulate_run(const CampaignConfig& config, const SimulatedUnit& unit, int run,
                              const std::vector<SetPoint>& set_points) {
  const RunPlan plan = plan_run(config, set_points, run);
  const std::uint64_t seed = run_seed(unit, run);
  const RunTemperature temperature(config, plan.visits, seed);

  calib::Recording recording;
  recording.run_id = run_label(run);
  recording.unit = unit.serial;
  record_plan(plan, recording);
  record_thermometers(config, plan, temperature, seed, recording);
  for (const calib::Sensor sensor : calib::kSensors) {
    SensorNoise noise(config, sensor, seed);
    const double offset = power_on_offset(config, unit, run, sensor);
    std::vector<double>& values = recording.sensor[calib::index_of(sensor)];
    for (std::size_t i = 0; i < plan.rows.size(); ++i) {
      const PlannedRow& row = plan.rows[i];
      const double temp_c = temperature.unit_c(row.visit, row.t_s);
      const calib::Vector3 force_mps2 = force_at_rest_mps2(row.attitude.up);
      values.push_back(ideal_reading(unit, sensor, temp_c, force_mps2, row.attitude.rate_rps) + offset +
                       noise.at(i, row.t_s));
    }
  }
  return recording;
}

calib::Recording simulate_campaign_run(const CampaignConfig& config, const SimulatedUnit& unit, int run) {
  return simulate_run(config, unit, run, campaign_set_points(config));
}

calib::Recording simulate_verification_run(const CampaignConfig& config, const SimulatedUnit& unit) {
  return simulate_run(config, unit, kVerificationRun, verification_set_points(config));
}

}  // namespace soak::hal::sim
