// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// Where a plateau was, and from which side it was reached.
struct MapRow {
  double temp_c = 0.0;
  Sweep sweep = Sweep::unknown;
};

/// Means of what one sensor read beyond the base, SI; [row][column], absent where nothing was recorded.
using MapCells = std::vector<std::vector<std::optional<double>>>;

/// One sensor's part of a map.
struct SensorMap {
  /// Standard error of each cell: how runs differ in a cell (variance pooled over the cells), over √(runs of this one);
  /// absent where nothing was recorded. Empty where no run repeats what another has.
  MapCells sigma;
  MapCells before;
  MapCells after;  ///< with the effects; empty where there are none
};

/// What the model's kind does not explain of a campaign, by plateau and position, for a person to look at.
struct RemainderMap {
  std::vector<MapRow> rows;            ///< in the order in which the campaign came there
  std::vector<std::string> positions;  ///< columns; empty label: the position is not known
  std::array<std::optional<SensorMap>, kSensorCount> sensor;
};

/// Readings less the saturated base of all runs, and less base and effects fitted together: first the mean of each run
/// at a plateau (reached from one side) in a position, then that of the runs. So an effect that a run shows both ways
/// does not cancel where heating and cooling share a temperature. Sensors that cannot be judged have no part. `plain`:
/// the base without terms, fitted to all runs.
[[nodiscard]] RemainderMap remainder_map(const CampaignModel& plain, const std::vector<NamedEffect>& effects);

/// The key `map` of `soak gap find --json` (docs/schema/gap-find.schema.json): deg/s and m/s².
[[nodiscard]] nlohmann::json map_json(const RemainderMap& map);

}  // namespace soak::calib::gap
