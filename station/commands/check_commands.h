// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak check declare UNIT --reason TEXT, soak check end UNIT --reason TEXT
struct CheckRecordCommand {
  std::string data;
  std::string unit;
  std::string reason;
};

/// soak check chart [--unit SN]
struct CheckChartCommand {
  std::string data;
  std::optional<std::string> unit;  ///< absent: all that are check standards now
};

/// Makes a unit that is there a check standard.
[[nodiscard]] base::Status run_check_declare(const CheckRecordCommand& command, Output& output);
/// Ends that. Refuses a unit that is none.
[[nodiscard]] base::Status run_check_end(const CheckRecordCommand& command, Output& output);
/// Prints the charts. Verdicts do not change the exit status.
[[nodiscard]] base::Status run_check_chart(const CheckChartCommand& command, Output& output);

}  // namespace soak::station
