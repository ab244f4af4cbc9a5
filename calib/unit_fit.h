// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve_data.h"
#include "calib/curve_fit.h"
#include "calib/gravity.h"
#include "calib/reference.h"
#include "calib/segment.h"
#include "calib/six_position.h"
#include "calib/unit_type.h"
#include "calib/warning.h"

namespace soak::calib {

/// One run of a unit, as a fit takes it.
struct RunInput {
  std::string run_id;
  std::string label;
  std::string campaign;
  std::string content_sha256;
  bool simulated = false;
  Site site;
  std::vector<Segment> segments;
};

/// A unit with the runs of one epoch.
struct UnitInput {
  std::string unit;  ///< serial number
  UnitType type;
  std::int32_t epoch = 0;
  std::vector<RunInput> runs;
  std::vector<ReferenceUse> references;  ///< of the campaigns of its runs
};

/// Constant response to specific force, averaged over runs: row i is sensor i of its kind, columns x, y, z.
struct Coupling {
  std::array<Vector3, 3> value{};
  std::array<Vector3, 3> standard_error{};
};

/// The rows of a unit's thermal fits, ready to be fitted sensor by sensor.
struct UnitRows {
  std::array<std::optional<CurveData>, kSensorCount> bias;
  std::array<std::optional<CurveData>, kSensorCount>
      scale;                    ///< accelerometers turned up and down, gyros turned at rates
  bool relative_accel = false;  ///< one attitude: accelerometer bias has no level of its own
  Gravity gravity;
  std::optional<Coupling> accel_misalignment;
  std::optional<Coupling> g_sensitivity;  ///< holds the horizontal part of the Earth's rotation where that is unknown
  std::vector<Warning> warnings;
};

/// Estimates of every run (six-position estimation per plateau; 30-second blocks where no run has plateaus) as rows.
/// Segments that the data gate rejected, and sensors that it rejected in a segment, are left out; `warnings` says so.
/// Refuses a unit without runs, or of which the gate leaves nothing, a sensor whose every sample in a run is the same
/// number, runs that give no row, and accelerometers whose readings up and down are not those of gravity to 20 % (wrong
/// sign, unit or position), naming the remedy.
[[nodiscard]] base::Result<UnitRows> make_rows(const UnitInput& input);

/// Thermal model of one sensor.
struct SensorFit {
  CurveFit bias;
  std::optional<CurveFit> scale;  ///< ppm
  bool relative = false;          ///< bias is relative to that at 25 °C
  std::vector<Warning> warnings;
};

/// Fits one sensor. The six sensors are independent: callers may run them in parallel.
[[nodiscard]] base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options);

}  // namespace soak::calib
