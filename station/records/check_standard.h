// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/judge/control_chart.h"
#include "calib/judge/reference_plateau.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

/// Check standards: units that are measured in every campaign, so that a change in what they read is a change of the
/// station (docs/check-standard.md).
namespace soak::station {

/// One run of a check standard.
struct CheckRun {
  std::string label;
  calib::RunAtReference reference;
};

/// What a campaign says of one sensor of a check standard, SI.
struct CheckSensor {
  /// Mean over runs at CheckChart::temp_c. Standard error from the scatter of the runs; of one run, its own.
  calib::Estimate bias;
  std::optional<calib::Estimate> drift;  ///< in-run drift, the same mean
  calib::ControlPoint point;             ///< on the chart of that sensor
};

/// One point of the charts of a check standard.
struct CheckCampaign {
  std::string name;
  double created_utc_s = 0.0;  ///< of its first run
  bool simulated = false;
  std::vector<CheckRun> runs;
  std::array<std::optional<CheckSensor>, calib::kSensorCount> sensor;  ///< none: no run was near the reference plateau
  /// Out of control where one sensor is; in control where one was judged and none is out.
  calib::ControlVerdict verdict = calib::ControlVerdict::not_established;
};

/// The charts of one check standard: a point per campaign and sensor.
struct CheckChart {
  std::string unit;
  std::int32_t epoch = 0;
  std::optional<db::EndRecord> ended;  ///< it is no check standard any more
  /// Temperature of each sensor's thermometer that its biases are carried to: its mean over the first campaign.
  std::array<std::optional<double>, calib::kSensorCount> temp_c;
  std::vector<CheckCampaign> campaigns;  ///< in the order of their first runs
};

/// The charts of `unit`, or, without one, of all units that are check standards now. A chart holds the sealed, unvoided
/// calibration runs of the unit's current epoch since the unit's record before the last one ended (since ever, where
/// there is but one) and until the last one ended. Refuses a unit without a record, and a station without check
/// standards.
[[nodiscard]] base::Result<std::vector<CheckChart>> check_charts(const db::Catalog& catalog,
                                                                 const std::optional<std::string>& unit);

/// The charts, as check_charts() makes them, of the check standards that are or were in one of these campaigns.
[[nodiscard]] base::Result<std::vector<CheckChart>> check_charts_of(const db::Catalog& catalog,
                                                                    const std::set<std::string>& campaigns);

/// What a check standard says of a campaign in which it was.
struct CheckVerdict {
  std::string unit;
  std::string campaign;
  calib::ControlVerdict verdict = calib::ControlVerdict::not_established;
  std::vector<std::string> findings;  ///< one sentence per sensor that is out of control
};

/// The verdicts of the check standards among the units of a campaign: those on whose charts (as check_charts() makes
/// them) the campaign is. Empty: it has none.
[[nodiscard]] base::Result<std::vector<CheckVerdict>> check_standard_of(const db::Catalog& catalog,
                                                                        std::string_view campaign);

/// What to say when a campaign for calibration starts with these units: a sentence where the station has a check
/// standard now and none of the units is one, else nothing.
[[nodiscard]] base::Result<std::optional<std::string>> missing_check_standard(const db::Catalog& catalog,
                                                                              const std::vector<std::string>& units);

/// What must be told of any unit of that campaign: `check_standard_out_of_control`, or nothing.
[[nodiscard]] std::optional<calib::Warning> warning_of(const CheckVerdict& verdict);

/// docs/schema/check-chart.schema.json
[[nodiscard]] nlohmann::json check_document(const std::vector<CheckChart>& charts);

}  // namespace soak::station
