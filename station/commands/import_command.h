// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "station/import.h"
#include "station/output.h"

namespace soak::station {

/// soak import FILE.csv --unit SN ...
struct ImportCommand {
  std::string data;
  std::string file;
  std::string columns;  ///< path of a columns map; empty = our own headers
  bool skip_bad = false;
  ImportOptions import;
};

[[nodiscard]] base::Status run_import(const ImportCommand& command, Output& output);

}  // namespace soak::station
