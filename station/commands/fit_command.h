// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak fit (--unit SN | --all) [--campaign NAME] [--rules auto|N] [--jobs N] [--chamber-time]
struct FitCommand {
  std::string data;
  std::string unit;  ///< empty with `all`
  bool all = false;
  std::optional<std::string> campaign;
  std::optional<int> rules;   ///< absent = auto
  int jobs = 0;               ///< threads; 0 = one per core
  bool chamber_time = false;  ///< also what a shorter campaign would have given
};

[[nodiscard]] base::Status run_fit(const FitCommand& command, Output& output);

}  // namespace soak::station
