// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak procedure check FILE [--type NAME]... [--types DIR] [--steps]
struct ProcedureCheckCommand {
  std::string file;
  std::vector<std::string> types;  ///< unit types whose rating must bear it; empty = one of all must that state one
  std::string type_folder;         ///< empty = default_unit_type_folder(), which may be missing
  bool all_steps = false;          ///< list every step instead of one line per run
};

[[nodiscard]] base::Status run_procedure_check(const ProcedureCheckCommand& command, Output& output);

}  // namespace soak::station
