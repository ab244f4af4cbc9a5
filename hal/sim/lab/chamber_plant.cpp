// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/chamber_plant.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

/// Share of full power below which the compressor rests.
constexpr double kIdleRefrigeration = 0.01;

}  // namespace

ChamberPlant::ChamberPlant(const PlantMagnitudes& magnitudes)
    : magnitudes_(magnitudes), air_c_(magnitudes.room_c), load_c_(magnitudes.room_c) {}

double ChamberPlant::compressor_cycle() const {
  return in_running_half() ? 1.0 + magnitudes_.compressor_depth : 1.0 - magnitudes_.compressor_depth;
}

bool ChamberPlant::compressor_runs() const { return in_running_half() && refrigeration_ > kIdleRefrigeration; }

void ChamberPlant::step(double dt_s, double output) {
  const PlantMagnitudes& m = magnitudes_;
  heater_ += dt_s / m.heater_lag_s * (std::max(output, 0.0) - heater_);
  refrigeration_ += dt_s / m.refrigeration_lag_s * (std::max(-output, 0.0) - refrigeration_);
  compressor_s_ = std::fmod(compressor_s_ + dt_s, m.compressor_period_s);

  const double capacity = 1.0 + m.load_to_air;
  const double power_kps = capacity * (m.heating_kps * heater_ - m.cooling_kps * refrigeration_ * compressor_cycle());
  const double from_load_kps = m.load_to_air / m.load_settling_time_s * (load_c_ - air_c_);
  const double from_room_kps = capacity / m.leak_time_s * (m.room_c - air_c_);
  const double load_kps = (air_c_ - load_c_) / m.load_settling_time_s;
  air_c_ += dt_s * (power_kps + from_load_kps + from_room_kps);
  load_c_ += dt_s * load_kps;
}

void UnitHeat::step(double dt_s, const ChamberPlant& chamber, bool powered) {
  const double surroundings_c = chamber.air_c() + (powered ? self_heating_c_ : 0.0);
  temp_c_ +=
      dt_s * ((surroundings_c - temp_c_) / settling_time_s_ + (chamber.load_c() - temp_c_) / load_coupling_time_s_);
}

}  // namespace soak::hal::sim
