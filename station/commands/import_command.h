// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/import/import.h"
#include "station/io/output.h"

namespace soak::station {

/// soak import FILE --unit SN ...
struct ImportCommand {
  std::string data;
  std::string file;
  std::string columns;  ///< path of a columns map; empty = our own headers
  bool skip_bad = false;
  std::string decoder;  ///< "xsens", "ahrs400", "vectornav" of a file of the unit's own bytes; empty = it is CSV
  std::optional<double> rate_hz;  ///< that the unit sent at; with `decoder`, else 100 Hz
  ImportOptions import;
};

[[nodiscard]] base::Status run_import(const ImportCommand& command, Output& output);

}  // namespace soak::station
