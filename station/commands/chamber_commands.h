// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak chamber check FILE
struct ChamberCheckCommand {
  std::string file;
};

/// What a map can do; refuses (bad_input) one with mistakes, all of them with their lines.
[[nodiscard]] base::Status run_chamber_check(const ChamberCheckCommand& command, Output& output);

/// soak chamber probe FILE [--tcp HOST[:PORT] | --serial DEVICE] [--baud N] [--unit N]
struct ChamberProbeCommand {
  std::string file;
  std::string tcp;     ///< empty = as the map says
  std::string serial;  ///< a serial device; empty = as the map says
  int baud = 0;        ///< of `serial`; 0 = as the map says, else 9600
  int unit = -1;       ///< Modbus unit; negative = as the map says
};

/// What a live controller says, read without writing. Prints it also where some of it is of no use, and then fails
/// (device).
[[nodiscard]] base::Status run_chamber_probe(const ChamberProbeCommand& command, Output& output);

}  // namespace soak::station
