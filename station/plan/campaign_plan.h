// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/plan/expected_band.h"
#include "calib/vocabulary/sensor.h"
#include "station/plan/campaign_design.h"
#include "station/plan/type_picture.h"

namespace soak::station {

/// What is asked of a plan. Nothing: the cheapest design that is as good as the full campaign, in shape and in all.
struct PlanRequest {
  std::optional<double> gyro;   ///< widest half-width of the 95 % band of the mean curve, rad/s
  std::optional<double> accel;  ///< m/s²
  std::optional<double> hours;  ///< of the chamber, at most
};

/// A design with what it costs and buys.
struct PlanOption {
  PassDesign design;
  double hours = 0.0;
  int power_ons = 0;
  std::array<std::optional<calib::ExpectedBand>, calib::kSensorCount> bands;
  /// The worst sensor's widest curve95 over what is asked of it; where nothing is asked, its widest shape95 or curve95
  /// over that of the full campaign, whichever is worse. 1 is just good enough.
  double relative = 0.0;
};

/// Designs beside each other.
struct CampaignPlan {
  /// Rising hours, each at least 5 % better than the one before it (Pareto front), and the chosen one.
  std::vector<PlanOption> options;
  std::size_t chosen = 0;  ///< index into options
  PlanOption full;         ///< full_campaign()
};

/// The cheapest design with `relative` at most 1; where hours are limited and none of those is short enough, the best
/// within them. Refuses (bad_input) a target that no design reaches and hours that none keeps, saying what can be had,
/// and a target for sensors of which the picture knows nothing.
[[nodiscard]] base::Result<CampaignPlan> plan_campaign(const TypePicture& picture, const calib::UnitType& type,
                                                       const PlanRequest& request);

/// The document of `soak plan --json` (docs/schema/plan.schema.json), in deg/s and m/s², without `file`.
[[nodiscard]] nlohmann::json plan_json(const CampaignPlan& plan, const TypePicture& picture, const std::string& type,
                                       const PlanRequest& request);

}  // namespace soak::station
