// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/gap/base/campaign_model.h"

namespace soak::calib::gap {

/// Two runs with the very same readings, in words; nothing where all differ.
[[nodiscard]] std::optional<std::string> same_readings(const Observations& observations);

/// Why runs cannot be of one unit, mounted and recorded alike, in words that name those that differ; nothing where they
/// can. The first of these that holds:
/// - thermometers that read more than 10 K (RMS over the plateaus that two runs share) off each other at the same set
///   points: another unit of temperature, or one that is stuck;
/// - shapes of the curves over temperature that are further apart than five times what readings scatter within runs
///   (CellMeans), in two sensors or more (in the only one): another unit, swapped axes, turned signs, another unit of
///   measurement. Offsets, tilts and what follows the temperature history of a run leave the shapes alone. Runs that
///   are not apart, directly or by way of others, belong together; more than one such group is too many;
/// - of three runs or more, one whose mean square about the base is 16 times the median, in most sensors.
[[nodiscard]] std::optional<std::string> disagreement(const CampaignModel& model);

}  // namespace soak::calib::gap
