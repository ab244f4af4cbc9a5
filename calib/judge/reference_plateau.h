// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/estimate/six_position.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/sensor.h"

/// The reference plateau of a run: the temperature near that of a room at which each run begins and ends, so that runs
/// can be compared with each other, and the end of a run with its beginning.
namespace soak::calib {

/// Set point at which campaigns are compared.
inline constexpr double kReferencePlateau_c = 25.0;
/// A set point farther away is no reference plateau.
inline constexpr double kReferenceReach_c = 2.5;
/// Set points this near to each other are the same one, as in plateaus.h.
inline constexpr double kSameSetPoint_c = 1.0;

/// What one run says of one sensor there, SI.
struct SensorReference {
  Estimate bias;        ///< mean of the visits
  double temp_c = 0.0;  ///< mean of the sensor's own thermometer over these visits: what the bias belongs to
  /// Slope of the run's biases against temperature within 12.5 K; none where they are not 2 K apart.
  std::optional<double> slope_per_k;
  std::optional<Estimate> first;  ///< bias at the visit that began the run
  std::optional<Estimate> last;   ///< ... and at the one that ended it
  /// In-run drift, last − first, at the temperature of the first. Warm-up, hysteresis and what handling did to the unit
  /// are in it.
  std::optional<Estimate> drift;
};

struct RunAtReference {
  /// Whether the run began and ended at the reference plateau.
  bool at_both_ends = false;
  std::vector<std::int32_t> visits;  ///< that the biases come from; empty = the run was never near there
  std::array<std::optional<SensorReference>, kSensorCount> sensor;
};

/// Finds the visits from what is stored of any run, recorded here or imported: where the first and the last plateau in
/// time have the same set point (to 1 K), not more than 2.5 K from 25 °C, and another one lies between them, these are
/// its reference visits. Otherwise all visits at the set point nearest to 25 °C within 2.5 K are taken, and there is no
/// drift. The biases are those of estimate_six_positions() over the whole run without what the data gate rejected; of
/// two visits their standard errors count as independent. Void segments must not be among the run's.
[[nodiscard]] RunAtReference reference_plateau(const RunInput& run, const UnitType& type);

/// The bias carried to another temperature along the slope; without a slope, over 0.5 K at most and unchanged. None
/// where it cannot be.
[[nodiscard]] std::optional<Estimate> carried_to(const SensorReference& reference, double temp_c);

}  // namespace soak::calib
