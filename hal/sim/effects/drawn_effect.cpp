// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/drawn_effect.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;

/// Two effects of the same seed share nothing.
std::uint64_t seed_of(const HiddenSpec& spec) {
  std::uint64_t seed = spec.seed;
  for (const char letter : spec.effect) seed = base::hashed(seed, 0, static_cast<unsigned char>(letter));
  return seed;
}

std::vector<Sensor> sensors_of_kind(bool gyros) {
  const auto first = calib::kSensors.begin() + (gyros ? 0 : 3);
  return {first, first + 3};
}

Sensor one_of(const std::vector<Sensor>& sensors, base::Random& random) {
  return sensors[static_cast<std::size_t>(random.uniform() * static_cast<double>(sensors.size()))];
}

std::vector<Sensor> drawn_sensors(Hits hits, base::Random& random) {
  std::vector<Sensor> everything(calib::kSensors.begin(), calib::kSensors.end());
  const double dice = random.uniform();
  switch (hits) {
    case Hits::all:
      return everything;
    case Hits::all_gyros:
    case Hits::all_accels:
      return sensors_of_kind(hits == Hits::all_gyros);
    case Hits::some_gyros:
    case Hits::some_accels: {
      const std::vector<Sensor> three = sensors_of_kind(hits == Hits::some_gyros);
      return dice < 0.5 ? std::vector<Sensor>{one_of(three, random)} : three;
    }
    case Hits::some:
      break;
  }
  if (dice < 0.4) return {one_of(everything, random)};
  if (dice < 0.8) return sensors_of_kind(dice < 0.6);
  return everything;
}

/// A weight for each of `count` sensors; the largest is 1.
std::vector<double> drawn_weights(std::size_t count, base::Random& random) {
  std::vector<double> weights(count);
  double largest = 0.0;
  for (double& weight : weights) {
    weight = drawn_sign(random) * random.uniform(0.5, 1.0);
    largest = std::max(largest, std::abs(weight));
  }
  for (double& weight : weights) weight /= largest;
  return weights;
}

}  // namespace

DrawnEffect draw_effect(const HiddenSpec& spec, int number, double mps2_per_dps) {
  DrawnEffect drawn;
  drawn.entry = catalogue_entry(spec.effect);
  drawn.seed = base::hashed(seed_of(spec), stream_of(Purpose::hidden_shape), static_cast<std::uint64_t>(number));
  base::Random random(drawn.seed, stream_of(Purpose::hidden_sensors));
  drawn.sensors = spec.sensors.empty() ? drawn_sensors(drawn.entry->hits, random) : spec.sensors;
  std::sort(drawn.sensors.begin(), drawn.sensors.end());
  const bool weighted = drawn.entry->weighted && spec.magnitude.has_value();
  const std::vector<double> weights =
      weighted ? drawn_weights(drawn.sensors.size(), random) : std::vector<double>(drawn.sensors.size(), 1.0);
  // Of one kind of sensor, or of a mechanism whose amplitude is in the unit of no sensor, no kind needs another weight.
  const bool both_kinds = calib::is_gyro(drawn.sensors.front()) && drawn.entry->unit.starts_with('*');
  for (std::size_t i = 0; i < drawn.sensors.size(); ++i) {
    const Sensor sensor = drawn.sensors[i];
    const double kind = both_kinds && !calib::is_gyro(sensor) ? mps2_per_dps : 1.0;
    drawn.weight[calib::index_of(sensor)] = kind * weights[i];
  }
  return drawn;
}

double amplitude_of(const DrawnEffect& drawn, Sensor sensor, double amplitude) {
  return amplitude * drawn.weight[calib::index_of(sensor)];
}

}  // namespace soak::hal::sim
