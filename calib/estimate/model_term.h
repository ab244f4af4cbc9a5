// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// A number of an accepted term. Its name within the term fixes its meaning (docs/gap-terms.md); SI but for °C.
struct TermParameter {
  std::string name;
  double value = 0.0;
  std::string unit;
};

/// What a term is in one sensor, or in all that share its parameters.
struct TermPart {
  std::vector<Sensor> sensors;
  std::vector<TermParameter> parameters;  ///< those that were estimated first, then those that define the shape
  std::vector<double> covariance;         ///< of the estimated ones, row by row, in the products of their units
  /// What is taken off the mechanism: its mean over the procedure, at temperatures in °C, SI; linear between, held
  /// beyond. For effects of a unit's past, which not every reader of a file evaluates: its curves keep that mean. Empty
  /// = 0.
  std::vector<std::pair<double, double>> centre;

  [[nodiscard]] bool acts_on(Sensor sensor) const { return std::ranges::find(sensors, sensor) != sensors.end(); }
  /// Value of a parameter; nothing where the part has none of that name.
  [[nodiscard]] std::optional<double> value(std::string_view name) const {
    const auto found = std::ranges::find(parameters, name, &TermParameter::name);
    return found == parameters.end() ? std::nullopt : std::optional(found->value);
  }
};

/// The gap of one sensor when a term was accepted, SI: RMS of blocks on runs that neither base nor parameters saw.
struct TermGap {
  double before_rms = 0.0;
  double after_rms = 0.0;
  double floor_rms = 0.0;
  std::optional<double> closed_fraction;
  std::optional<std::pair<double, double>> closed_ci95;
};

/// An effect that `gap accept` added to a model: what it is, and why it was believed.
struct ModelTerm {
  std::string name;                 ///< of the effect (design: names for missing effects)
  std::string library;              ///< version of the library of effects that named it
  std::int32_t parent_version = 0;  ///< model in which it was found missing
  bool lab_only = false;            ///< cannot be evaluated from the course of the unit's own temperature
  std::vector<TermPart> parts;      ///< no sensor twice
  double temp_min_c = 0.0;          ///< range of temperature that it was estimated over
  double temp_max_c = 0.0;
  double p_adjusted = 1.0;  ///< chance that scatter looks like it, over the whole library
  double delta_bic = 0.0;
  double heldout_gain = 0.0;
  std::string verdict;  ///< of the report that named it
  std::vector<std::string> confusable_with;
  std::vector<std::string> run_hashes;  ///< content of the runs used; each of them was also held out once
  std::array<std::optional<TermGap>, kSensorCount> gap;  ///< of the whole report, all its terms together

  /// The part that acts on a sensor; null where none does.
  [[nodiscard]] const TermPart* part_of(Sensor sensor) const {
    const auto found = std::ranges::find_if(parts, [&](const TermPart& part) { return part.acts_on(sensor); });
    return found == parts.end() ? nullptr : &*found;
  }
};

}  // namespace soak::calib
