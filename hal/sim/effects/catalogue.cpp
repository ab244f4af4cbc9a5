// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/catalogue.h"

#include <algorithm>
#include <array>

#include "hal/sim/effects/detail/aging_drift.h"
#include "hal/sim/effects/detail/bias_step.h"
#include "hal/sim/effects/detail/cross_axis.h"
#include "hal/sim/effects/detail/daily_wave.h"
#include "hal/sim/effects/detail/earth_rate.h"
#include "hal/sim/effects/detail/fixture_tilt.h"
#include "hal/sim/effects/detail/g_sensitivity.h"
#include "hal/sim/effects/detail/gradient_rate.h"
#include "hal/sim/effects/detail/moisture.h"
#include "hal/sim/effects/detail/narrow_bump.h"
#include "hal/sim/effects/detail/noise_vs_temperature.h"
#include "hal/sim/effects/detail/position_memory.h"
#include "hal/sim/effects/detail/quantization.h"
#include "hal/sim/effects/detail/reposition_creep.h"
#include "hal/sim/effects/detail/saturation.h"
#include "hal/sim/effects/detail/scale_nonlinearity.h"
#include "hal/sim/effects/detail/sensor_lag.h"
#include "hal/sim/effects/detail/supply_sensitivity.h"
#include "hal/sim/effects/detail/telegraph_noise.h"
#include "hal/sim/effects/detail/temperature_rate.h"
#include "hal/sim/effects/detail/thermal_hysteresis.h"
#include "hal/sim/effects/detail/vibration_rectification.h"
#include "hal/sim/effects/detail/warmup_transient.h"

namespace soak::hal::sim {
namespace {

// clang-format off
constexpr CatalogueEntry kCatalogue[] = {
    {"thermal_hysteresis", true, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_thermal_hysteresis},
    {"temperature_rate", true, Hits::some, Measure::blocks, AmplitudeSign::any, true, "* per K/min",
     make_temperature_rate},
    {"sensor_lag", true, Hits::all, Measure::blocks, AmplitudeSign::positive, false, "s",
     make_sensor_lag},
    {"warmup_transient", true, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_warmup_transient},
    {"g_sensitivity", true, Hits::some_gyros, Measure::blocks, AmplitudeSign::any, false, "* per g",
     make_g_sensitivity},
    {"earth_rate", true, Hits::all_gyros, Measure::blocks, AmplitudeSign::any, false, "*",
     make_earth_rate},
    {"cross_axis", true, Hits::some_accels, Measure::blocks, AmplitudeSign::any, false, "rad per K",
     make_cross_axis},
    {"fixture_tilt", true, Hits::all_accels, Measure::blocks, AmplitudeSign::any, false, "deg",
     make_fixture_tilt},
    {"scale_nonlinearity", true, Hits::some_accels, Measure::blocks, AmplitudeSign::any, true, "* per g2",
     make_scale_nonlinearity},
    {"narrow_bump", true, Hits::some, Measure::curve, AmplitudeSign::any, true, "*",
     make_narrow_bump},
    {"vibration_rectification", true, Hits::some, Measure::blocks, AmplitudeSign::any, true, "* per unit duty",
     make_vibration_rectification},
    {"supply_sensitivity", true, Hits::some, Measure::blocks, AmplitudeSign::any, true, "* per V",
     make_supply_sensitivity},
    {"aging_drift", true, Hits::some, Measure::runs, AmplitudeSign::any, true, "* per 1000 h",
     make_aging_drift},
    {"noise_vs_temperature", true, Hits::some, Measure::block_noise, AmplitudeSign::any, false, "relative per K",
     make_noise_vs_temperature},
    {"quantization", true, Hits::some, Measure::row_noise, AmplitudeSign::positive, false, "*",
     make_quantization},
    {"saturation", true, Hits::some_accels, Measure::clipped_share, AmplitudeSign::positive, false, "*",
     make_saturation},
    {"reposition_creep", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_reposition_creep},
    {"position_memory", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_position_memory},
    {"daily_wave", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_daily_wave},
    {"telegraph_noise", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_telegraph_noise},
    {"gradient_rate", false, Hits::some_gyros, Measure::blocks, AmplitudeSign::any, true, "* per K/min",
     make_gradient_rate},
    {"bias_step", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_bias_step},
    {"moisture", false, Hits::some, Measure::blocks, AmplitudeSign::any, true, "*",
     make_moisture},
};
// clang-format on

}  // namespace

std::span<const CatalogueEntry> catalogue() { return kCatalogue; }

const CatalogueEntry* catalogue_entry(std::string_view name) {
  const auto found = std::find_if(std::begin(kCatalogue), std::end(kCatalogue),
                                  [name](const CatalogueEntry& entry) { return entry.name == name; });
  return found == std::end(kCatalogue) ? nullptr : found;
}

bool can_hit(Hits hits, calib::Sensor sensor) {
  switch (hits) {
    case Hits::some_gyros:
    case Hits::all_gyros:
      return calib::is_gyro(sensor);
    case Hits::some_accels:
    case Hits::all_accels:
      return !calib::is_gyro(sensor);
    case Hits::some:
    case Hits::all:
      return true;
  }
  return false;
}

bool can_choose_sensors(Hits hits) {
  return hits == Hits::some || hits == Hits::some_gyros || hits == Hits::some_accels;
}

std::string_view description_of(Hits hits) {
  constexpr std::array<std::string_view, 6> kTexts = {
      "any sensors", "gyros", "accelerometers", "all gyros alike", "all accelerometers alike", "all sensors alike"};
  return kTexts[static_cast<std::size_t>(hits)];
}

std::string unit_of(const CatalogueEntry& entry, calib::Sensor sensor) {
  if (!entry.unit.starts_with('*')) return std::string(entry.unit);
  return std::string(calib::printed_unit(sensor)).append(entry.unit.substr(1));
}

}  // namespace soak::hal::sim
