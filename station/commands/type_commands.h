// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "station/io/output.h"

namespace soak::station {

/// soak type list [--types DIR]
struct TypeListCommand {
  std::string folder;  ///< empty = default_unit_type_folder()
};

/// soak type show NAME [--types DIR]
struct TypeShowCommand {
  std::string folder;
  std::string name;
};

[[nodiscard]] base::Status run_type_list(const TypeListCommand& command, Output& output);
[[nodiscard]] base::Status run_type_show(const TypeShowCommand& command, Output& output);

/// The type of that name; refuses one that the folder (empty = default_unit_type_folder()) does not hold.
[[nodiscard]] base::Result<calib::UnitType> find_unit_type(const std::string& folder, const std::string& name);

}  // namespace soak::station
