// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/plan/sensor_picture.h"
#include "calib/vocabulary/sensor.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

/// What a campaign of so many hours buys, before it is run.
namespace soak::station {

/// Units of a type that a picture is made of, at most: the last ones by serial number that have a model.
inline constexpr std::size_t kMostUnitsOfPicture = 8;

/// What is expected of units of a type before their campaign.
struct TypePicture {
  std::array<std::optional<calib::SensorPicture>, calib::kSensorCount> sensors;  ///< absent: nothing is known
  double low_c = 0.0;  ///< plateaus of the stored runs; where nothing is stored the rating, less the overshoot
  double high_c = 0.0;
  std::vector<std::string> units;        ///< serial numbers; empty: from the type's data sheet
  bool simulated = false;                ///< the units are simulated ones
  std::vector<std::string> remarks;      ///< sentences: what is assumed and was not measured
  std::vector<calib::Warning> warnings;  ///< about the units' stored runs
};

/// From the stored runs of the type's units that have a model, of measured ones where there are any, else of simulated
/// ones; of sensors that they do not show, and where there are no such units, from the limits of the type's file, with
/// remarks that say so. Refuses (bad_input) a type that has neither, one without a temperature rating, one whose rating
/// no run can end in (end_of_runs_c()), and a range narrower than kNarrowestRange_c; fails (corrupt) for damaged runs.
[[nodiscard]] base::Result<TypePicture> picture_of_type(const db::Catalog& catalog, const calib::UnitType& type);

}  // namespace soak::station
