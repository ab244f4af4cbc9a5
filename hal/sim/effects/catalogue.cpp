// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/catalogue.h"

#include <algorithm>
#include <array>

#include "hal/sim/effects/detail/effect_makers.h"

namespace soak::hal::sim {
namespace {

constexpr bool kNameable = true;
constexpr bool kInNoLibrary = false;  // a workflow that names another effect for it is wrong
constexpr bool kWeighted = true;
constexpr bool kEqual = false;

// A response is what one unit of amplitude adds to the reading. The makers draw the shape: its ranges stand there.
constexpr CatalogueEntry kCatalogue[] = {
    // Stress that follows the temperature with play (Prandtl and Ishlinskii): +1 after a long way up, −1 after a long
    // way down, whatever the speed and however long ago; grows or shrinks with temperature about 25 °C.
    {"thermal_hysteresis", "*", Hits::some, kNameable, kWeighted, make_thermal_hysteresis},
    // Thermal gradients in the unit: the rate of its temperature, 1 at 1 K/min, with a slope in temperature.
    {"temperature_rate", "* per K/min", Hits::some, kNameable, kWeighted, make_temperature_rate},
    // The sensing elements are a thermal node of their own behind the thermometer's, the amplitude its time constant.
    {"sensor_lag", "s", Hits::all, kNameable, kEqual, make_sensor_lag, Measure::blocks, AmplitudeSign::positive},
    // Electronics that warm up after each power-on, a fast part and a slow one: 1 at power-on, then decaying.
    {"warmup_transient", "*", Hits::some, kNameable, kWeighted, make_warmup_transient},
    // Gyros that feel specific force: a 3 × 3 matrix times the force in g. Of each gyro that is hit either its own axis
    // alone or all three; the largest element of the matrix is 1.
    {"g_sensitivity", "* per g", Hits::some_gyros, kNameable, kEqual, make_g_sensitivity},
    // The rotation of the Earth, or of as much of it as nobody subtracts; the amplitude is the whole rate, 0.004178 °/s
    // the real one. While the fixture turns only the vertical part is felt.
    {"earth_rate", "*", Hits::all_gyros, kNameable, kEqual, make_earth_rate},
    // Sensing axes of accelerometers that bend with temperature: off-axis force times the kelvins above 25 °C.
    {"cross_axis", "rad per K", Hits::some_accels, kNameable, kEqual, make_cross_axis},
    // The unit sits a little crooked, each time it is mounted in another way: a small rotation of the body. The
    // amplitude is the standard deviation of its angle over mountings.
    {"fixture_tilt", "deg", Hits::all_accels, kNameable, kEqual, make_fixture_tilt},
    // Accelerometers whose springs are not the same both ways: the square of the force along the axis.
    {"scale_nonlinearity", "* per g2", Hits::some_accels, kNameable, kWeighted, make_scale_nonlinearity},
    // A resonance or a phase change in the package at one temperature: a Lorentzian, or a step that is smeared.
    {"narrow_bump", "*", Hits::some, kNameable, kWeighted, make_narrow_bump, Measure::curve},
    // Vibration of the compressor, which rises and falls with its spin-up, rectified by its square: 1 while it runs.
    {"vibration_rectification", "* per unit duty", Hits::some, kNameable, kWeighted, make_vibration_rectification},
    // A reference that follows the supply: volts above 5 V.
    {"supply_sensitivity", "* per V", Hits::some, kNameable, kWeighted, make_supply_sensitivity},
    // Ageing: thousands of hours since the unit was first seen, by the calendar.
    {"aging_drift", "* per 1000 h", Hits::some, kNameable, kWeighted, make_aging_drift, Measure::runs},
    // Noise that grows with temperature: standard deviation times e^(a·(T − 25 °C)) with the amplitude a.
    {"noise_vs_temperature", "relative per K", Hits::some, kNameable, kEqual, make_noise_vs_temperature,
     Measure::block_noise},
    // Output words with coarse steps: the nearest multiple of the amplitude.
    {"quantization", "*", Hits::some, kNameable, kEqual, make_quantization, Measure::row_noise,
     AmplitudeSign::positive},
    // Output words that go no further than a rail: clipped at minus and plus the amplitude.
    {"saturation", "*", Hits::some_accels, kNameable, kEqual, make_saturation, Measure::clipped_share,
     AmplitudeSign::positive},
    // Stress of the mount after each repositioning: every turn of the up vector adds its part along a direction of the
    // body (2 at most), which then decays.
    {"reposition_creep", "*", Hits::some, kInNoLibrary, kWeighted, make_reposition_creep},
    // The position before this one is not forgotten: the part of the last up vector along a direction of the body, for
    // as long as the unit rests in the next position.
    {"position_memory", "*", Hits::some, kNameable, kWeighted, make_position_memory},
    // Something in the building that follows the time of day: a sine of one period per day.
    {"daily_wave", "*", Hits::some, kInNoLibrary, kWeighted, make_daily_wave},
    // Random telegraph noise: a trap in the electronics that is full (+1) or empty (−1) for exponentially distributed
    // times.
    {"telegraph_noise", "*", Hits::some, kInNoLibrary, kWeighted, make_telegraph_noise},
    // A lid that the air heats before the board: how fast the difference between air and unit changes, 1 at 1 K/min,
    // smoothed by the heat capacity of the lid.
    {"gradient_rate", "* per K/min", Hits::some_gyros, kInNoLibrary, kWeighted, make_gradient_rate},
    // A bond that gives way: a step at a random time after each power-on, until the next one; 0.5 ... 1 of random sign.
    {"bias_step", "*", Hits::some, kInNoLibrary, kWeighted, make_bias_step},
    // Moisture in the package, driven out by heat and taken up again in the cold: water content between 0 and 1.
    {"moisture", "*", Hits::some, kNameable, kWeighted, make_moisture},
};

}  // namespace

std::span<const CatalogueEntry> catalogue() { return kCatalogue; }

const CatalogueEntry* catalogue_entry(std::string_view name) {
  const auto found = std::find_if(std::begin(kCatalogue), std::end(kCatalogue),
                                  [name](const CatalogueEntry& entry) { return entry.name == name; });
  return found == std::end(kCatalogue) ? nullptr : found;
}

bool can_hit(Hits hits, calib::Sensor sensor) {
  if (hits == Hits::some || hits == Hits::all) return true;
  return calib::is_gyro(sensor) == (hits == Hits::some_gyros || hits == Hits::all_gyros);
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
