// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hal/maps/device_map.h"
#include "settings/reader.h"

namespace soak::hal {

using Actions = std::map<std::string, std::vector<ActionStep>>;

/// What a quantity of the map lets a step write.
struct StepTarget {
  bool writable = false;
  std::string needs;  ///< the key that would make it writable
  std::optional<double> min;
  std::optional<double> max;
  std::map<std::string, int> codes;
  std::function<bool(double)> fits;  ///< whether the controller's form of the number can hold it
};

/// The quantity of that name, nothing where the map has none.
using FindTarget = std::function<std::optional<StepTarget>(const std::string& quantity)>;

/// The section [action] of a map of that kind. Refuses actions that the device does not know, steps that name no
/// quantity or one that is not written, values beyond its limits, and delays of more than 10 s together.
[[nodiscard]] Actions read_actions(const SettingsTable& root, const std::string& kind,
                                   const std::set<std::string>& known, const FindTarget& find);

/// The quantities that the actions write.
[[nodiscard]] std::set<std::string> written_by(const Actions& actions);

}  // namespace soak::hal
