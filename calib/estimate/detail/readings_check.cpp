// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/readings_check.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "calib/estimate/detail/problem.h"

namespace soak::calib {
namespace {

constexpr double kLargestReading = 1e6;  ///< deg/s or m/s²
/// No inertial unit is that far from its nominal scale; a swapped position or sign is off by 2.
constexpr double kLargestScaleError = 0.2;
constexpr double kOnAxis = 0.9;  ///< cosine beyond which an axis counts as pointing up or down

/// Refuses readings that no inertial sensor gives.
base::Status check_magnitude(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    for (const Segment& segment : run.segments) {
      for (const Sensor sensor : kSensors) {
        const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
        const double mean = statistics.mean * printed_per_si(sensor);
        if (statistics.count == 0 || std::abs(mean) <= kLargestReading) continue;
        return base::bad_input(
            fmt::format("{} of unit {} reads {:.3g} {} in run '{}': check the unit in the column's name, "
                        "void the run and import it again into another campaign",
                        name_of(sensor), input.unit, mean, printed_unit(sensor), run.label),
            std::string(name_of(sensor)));
      }
    }
  }
  return {};
}

/// Refuses a sensor that gave one and the same number throughout a run.
base::Status check_stuck(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    for (const Sensor sensor : kSensors) {
      std::set<double> means;
      std::size_t samples = 0;
      bool varies = false;
      for (const Segment& segment : run.segments) {
        const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
        if (statistics.count == 0) continue;
        samples += statistics.count;
        varies = varies || statistics.variance > 0.0;
        means.insert(statistics.mean);
      }
      if (samples < 2 || varies || means.size() != 1) continue;
      return base::bad_input(
          fmt::format(
              "{} of unit {} reads the constant {} in every one of {} samples of run '{}': a stuck or disconnected "
              "sensor; void the run ('soak runs void'), or import it without this column",
              name_of(sensor), input.unit, *means.begin() * printed_per_si(sensor), samples, run.label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

/// Middle reading of an accelerometer over the segments of a run in which its axis points up (or down: `sign` −1).
double typical_reading(const RunInput& run, Sensor sensor, double sign) {
  std::vector<double> means;
  for (const Segment& segment : run.segments) {
    const bool plateau = segment.plateau_c && segment.phase == Phase::soak && segment.position && !turns(segment);
    if (!plateau || segment.sensor[index_of(sensor)].count == 0) continue;
    if (sign * segment.position->up[axis_of(sensor)] > kOnAxis) means.push_back(segment.sensor[index_of(sensor)].mean);
  }
  return base::median(means);
}

/// Refuses runs whose accelerometers, turned up and down, cannot have read gravity: a wrong sign, unit or position
/// label.
base::Status check_gravity(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    const double g = gravity_at(run.site).mps2 * input.type.sign_at_rest;
    for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) {
      const double share = (typical_reading(run, sensor, 1.0) - typical_reading(run, sensor, -1.0)) / (2.0 * g);
      if (!(std::abs(share - 1.0) > kLargestScaleError)) continue;
      return base::bad_input(
          fmt::format(
              "{} of unit {} reads {:.3g} times gravity between its up and down positions in run '{}': check the "
              "sign of the axis (scale = -1 in a columns map), the position labels and the unit in the column's "
              "name, then void the run and import it into a new campaign",
              name_of(sensor), input.unit, share, run.label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

}  // namespace

base::Status check_readings(const UnitInput& input) {
  if (input.runs.empty()) {
    return base::bad_input(fmt::format("unit {} has no sealed, unvoided run in its current epoch to fit", input.unit));
  }
  if (auto sane = check_magnitude(input); !sane) return sane;
  if (auto alive = check_stuck(input); !alive) return alive;
  return check_gravity(input);
}

}  // namespace soak::calib
