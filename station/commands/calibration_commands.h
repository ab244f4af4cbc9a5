// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/sensor.h"
#include "station/io/output.h"

namespace soak::station {

/// soak export --unit SN --format blob|c|json|px4|ardupilot|kalibr -o FILE
struct ExportCommand {
  std::string data;
  std::string unit;
  std::string format;
  std::string file;
  std::optional<int> model;              ///< version; absent = the newest
  bool simulated = false;                ///< the user knows that the model comes from simulated data
  std::optional<int> instance;           ///< px4, ardupilot: which of the vehicle's units, from 0; absent = 0
  std::optional<std::int32_t> accel_id;  ///< px4: device ids; absent = left to the user
  std::optional<std::int32_t> gyro_id;
  std::optional<int> table;  ///< blob, c: curves as tables of at most so many points; absent = as fitted
  std::string sign;          ///< blob: secret key file to sign with; empty = unsigned
};

/// soak eval FILE.blob --temp-c T[,T...] [--own-temp-c SENSOR=T[,...]] [--raw GX,GY,GZ,AX,AY,AZ]
struct EvalCommand {
  std::string file;
  std::vector<double> temps_c;  ///< finite
  /// Of sensors with a thermometer of their own, at all temps_c.
  std::array<std::optional<double>, calib::kSensorCount> own_temps_c;
  std::optional<std::array<double, calib::kSensorCount>> raw;  ///< sample to correct, deg/s and m/s²
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
