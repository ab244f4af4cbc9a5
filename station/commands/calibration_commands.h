// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/output.h"

namespace soak::station {

/// soak export --unit SN --format blob|c|json -o FILE
struct ExportCommand {
  std::string data;
  std::string unit;
  std::string format;
  std::string file;
  std::optional<int> model;  ///< version; absent = the newest
  bool simulated = false;    ///< the user knows that the model comes from simulated data
};

/// soak eval FILE.blob --temp-c T[,T...]
struct EvalCommand {
  std::string file;
  std::vector<double> temps_c;  ///< finite
};

/// soak verify FILE.blob --campaign NAME [--limits FILE]
struct VerifyCommand {
  std::string data;
  std::string file;
  std::string campaign;
  std::string limits;  ///< path; empty = none
};

[[nodiscard]] base::Status run_export(const ExportCommand& command, Output& output);
[[nodiscard]] base::Status run_eval(const EvalCommand& command, Output& output);
[[nodiscard]] base::Status run_verify(const VerifyCommand& command, Output& output);

}  // namespace soak::station
