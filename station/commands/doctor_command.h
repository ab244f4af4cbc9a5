// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak doctor [--config FILE]
struct DoctorCommand {
  std::string data;
  std::string config;  ///< of the station; empty = no devices are looked at
};

/// Prints what was looked at. Fails with the kind of the gravest failure: stored data before devices before the rest.
[[nodiscard]] base::Status run_doctor(const DoctorCommand& command, Output& output);

}  // namespace soak::station
