// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// Thermal model of one sensor.
struct SensorFit {
  CurveFit bias;
  std::optional<CurveFit> scale;  ///< ppm
  bool relative = false;          ///< bias is relative to that at 25 °C
  std::vector<Warning> warnings;
};

/// Fits one sensor: curves over temperature, or constants where all rows are of one temperature
/// (is_of_one_temperature()). Refuses one attitude at one temperature, which leaves accelerometers nothing. The six
/// sensors are independent: callers may run them in parallel. A `narrow_bump` of the rows' terms is part of the
/// bias curve (bump_curve.h): the rows hold it, and so does what is fitted to them.
[[nodiscard]] base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options);

/// One version of a unit's thermal model: what `soak fit` makes.
struct UnitModel {
  std::string unit;
  std::string unit_type;
  std::int32_t epoch = 0;
  std::int32_t version = 0;
  double created_utc_s = 0.0;
  bool simulated = false;
  Gravity gravity;
  std::vector<RunReference> runs;
  std::vector<ReferenceUse> references;
  std::array<std::optional<SensorFit>, kSensorCount> sensors;
  std::array<bool, kSensorCount> own_thermometer{};  ///< as in UnitRows
  std::optional<Coupling> accel_misalignment;
  std::optional<Coupling> gyro_misalignment;
  std::optional<Coupling> g_sensitivity;  ///< estimated beside the model; enters it only by `gap accept`
  EarthRemoval earth_removed = EarthRemoval::none;
  std::array<std::optional<StatedValue>, 3> even_order;  ///< of the accelerometers, 1/(m/s²)
  LevelStatement level;                                  ///< of the chamber's side; concerns no unit
  CurveFitOptions options;                               ///< that it was fitted with
  std::vector<ModelTerm> terms;                          ///< accepted: the readings were freed of them before the fit
  std::vector<Warning> warnings;
};

/// A model from a unit's rows and its sensors' fits; version and time are the caller's.
[[nodiscard]] UnitModel make_model(UnitRows rows, std::array<std::optional<SensorFit>, kSensorCount> sensors);

/// What of a model leaves the lab.
[[nodiscard]] Calibration make_calibration(const UnitModel& model);

}  // namespace soak::calib
