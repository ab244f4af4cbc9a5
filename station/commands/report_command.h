// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak report --unit SN -o FILE.html [--model V] [--limits FILE]
struct ReportCommand {
  std::string data;
  std::string unit;
  std::string file;
  std::optional<int> model;  ///< version; absent = the newest
  std::string limits;        ///< path; empty = those of the unit's type
  std::string software;      ///< name and version of this program
};

/// Writes the page. A unit that fails its limits has its page all the same; the status is then that of `limits`.
[[nodiscard]] base::Status run_report(const ReportCommand& command, Output& output);

}  // namespace soak::station
