// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/simulated_run.h"

#include "base/random.h"
#include "base/units.h"
#include "hal/sim/campaign/detail/run_temperature.h"
#include "hal/sim/campaign/detail/sensor_noise.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

calib::Vector3 gravity_force_mps2(const calib::Vector3& up) {
  constexpr double g_mps2 = base::kStandardGravity_mps2;
  return {g_mps2 * up[0], g_mps2 * up[1], g_mps2 * up[2]};
}

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
      const calib::Vector3 force_mps2 = gravity_force_mps2(row.attitude.up);
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
