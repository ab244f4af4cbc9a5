// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/designed_campaign.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "base/random.h"
#include "hal/sim/unit/attitude.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

/// Index of a visit, or of a position in it, among all of a campaign.
std::uint64_t visit_index(const Moment& moment) {
  return (static_cast<std::uint64_t>(moment.conditions.mounting) << 16) | static_cast<std::uint64_t>(moment.visit);
}

std::uint64_t placement_index(const Moment& moment) {
  return (visit_index(moment) << 8) | static_cast<std::uint64_t>(moment.position + 1);
}

/// Noise of one unit's sensors, moment by moment.
class DesignReadout {
 public:
  DesignReadout(const CampaignConfig& config, const SimulatedUnit& unit)
      : design_(*config.design), seed_(base::hashed(unit.seed, stream_of(Purpose::design_noise), 0)) {}

  /// Noise that goes with a row: white, and that of its position and its visit.
  [[nodiscard]] double noise(Sensor sensor, const Moment& moment, std::size_t index) const {
    const DesignNoise& noise = design_.noise(sensor);
    const double drift = design_.drift_factor;
    return std::sqrt(kRowsPerBlock) * noise.block_sigma * gaussian(Purpose::design_noise, sensor, index) +
           drift * noise.placement_sigma * gaussian(Purpose::design_placement, sensor, placement_index(moment)) +
           drift * noise.visit_sigma * gaussian(Purpose::design_visit_scatter, sensor, visit_index(moment));
  }

  [[nodiscard]] double offset(Sensor sensor, int run) const {
    return design_.noise(sensor).run_sigma * gaussian(Purpose::power_on, sensor, static_cast<std::uint64_t>(run));
  }

  [[nodiscard]] double thermometer(Purpose purpose, std::size_t index) const {
    return base::hashed_gaussian(seed_, stream_of(purpose), index);
  }

 private:
  [[nodiscard]] double gaussian(Purpose purpose, Sensor sensor, std::uint64_t index) const {
    return base::hashed_gaussian(seed_, stream_of(purpose, calib::index_of(sensor)), index);
  }

  const DesignConfig& design_;
  std::uint64_t seed_;
};

double rounded_to(double value, double step) { return step > 0.0 ? step * std::round(value / step) : value; }

DesignedRow read_out(const CampaignConfig& config, const SimulatedUnit& unit, const DesignReadout& readout,
                     const HiddenEffects& effects, const Moment& moment, std::size_t index) {
  const Conditions& now = moment.conditions;
  DesignedRow row;
  row.moment = index;
  row.chamber_c = now.air_c + config.chamber.noise_sigma_c * readout.thermometer(Purpose::design_chamber, index);
  const double temp_c =
      now.thermometer_c + config.thermometer.noise_sigma_c * readout.thermometer(Purpose::design_thermometer, index);
  row.temp_c = rounded_to(temp_c, config.design->thermometer_step_c);
  for (const Sensor sensor : calib::kSensors) {
    const double ideal = ideal_reading(unit, sensor, effects.element_c(), force_at_rest_mps2(now.up), moment.rate_rps);
    const double felt = ideal + readout.offset(sensor, now.run);
    const double word = effects.sensed(sensor, felt, readout.noise(sensor, moment, index));
    row.sensor[calib::index_of(sensor)] = effects.output(sensor, word);
  }
  return row;
}

}  // namespace

SimulatedUnit draw_designed_unit(const CampaignConfig& config, int number) {
  SimulatedUnit unit = draw_unit(config, number);
  if (config.design->known_effects) return unit;
  for (SimulatedSensor& sensor : unit.sensors) sensor.g_sensitivity = {};
  return unit;
}

base::Result<DesignedUnit> simulate_designed_unit(const CampaignConfig& config, const CampaignTimeline& timeline,
                                                  int number) {
  DesignedUnit designed;
  designed.unit = draw_designed_unit(config, number);
  const EffectSizer sizer(config, timeline, designed.unit);
  designed.blocks = sizer.blocks();
  HiddenEffects effects;
  for (const HiddenSpec& spec : config.hidden) {
    auto effect = sizer.sized(spec, number);
    if (!effect) return base::forward_error(effect);
    effects.add(effect->drawn, effect->amplitude, design_surroundings(config));
    designed.effects.push_back(*std::move(effect));
  }
  for (const HiddenSpec& spec : config.candidates) {
    auto effect = sizer.sized(spec, number);
    if (!effect) return base::forward_error(effect);
    designed.candidates.push_back(*std::move(effect));
  }
  const DesignReadout readout(config, designed.unit);
  for (std::size_t i = 0; i < timeline.moments.size(); ++i) {
    const Moment& moment = timeline.moments[i];
    effects.advance_to(moment.conditions);
    if (!is_written(timeline, *config.design, moment)) continue;
    designed.rows.push_back(read_out(config, designed.unit, readout, effects, moment, i));
  }
  return designed;
}

}  // namespace soak::hal::sim
