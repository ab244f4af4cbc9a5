// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak unit list
struct UnitListCommand {
  std::string data;
};

/// soak unit show SN
struct UnitShowCommand {
  std::string data;
  std::string serial;
};

/// soak unit add SN [--type NAME] [--begin-epoch REASON]
struct UnitAddCommand {
  std::string data;
  std::string serial;
  std::optional<std::string> type;         ///< of a unit that is new
  std::optional<std::string> begin_epoch;  ///< why the unit is another from now on: repaired, re-flashed
  std::string user;                        ///< who begins it; empty = whoever is logged in
};

[[nodiscard]] base::Status run_unit_list(const UnitListCommand& command, Output& output);
[[nodiscard]] base::Status run_unit_show(const UnitShowCommand& command, Output& output);
[[nodiscard]] base::Status run_unit_add(const UnitAddCommand& command, Output& output);

}  // namespace soak::station
