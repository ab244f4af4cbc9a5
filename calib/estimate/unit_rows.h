// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/estimate/curve_data.h"
#include "calib/estimate/site.h"
#include "calib/estimate/unit_input.h"
#include "calib/vocabulary/one_way.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// A constant estimated from all runs, with what is known of its error.
struct StatedValue {
  double value = 0.0;
  double standard_error = 0.0;   ///< from the scatter of the readings
  double freedoms = 0.0;         ///< of a single run's standard error; 0 = many
  std::optional<double> type_b;  ///< standard uncertainty that the readings do not show; absent = not stated
  double ci95 = 0.0;             ///< half-width from both (JCGM 100:2008 G.4)
  bool by_choice = false;        ///< 0 by the choice of the axes: it has no error
};

/// Constant response to specific force, averaged over runs: row i is sensor i of its kind, columns x, y, z.
using Coupling = std::array<std::array<StatedValue, 3>, 3>;

/// What of the Earth's rotation was subtracted from the gyros.
enum class EarthRemoval : std::uint8_t { none, vertical, whole };

constexpr std::string_view name_of(EarthRemoval removal) {
  return removal == EarthRemoval::whole ? "whole" : removal == EarthRemoval::vertical ? "vertical" : "none";
}

/// Level error of the chamber's side (LevelError) over all runs.
struct LevelStatement {
  std::optional<std::array<StatedValue, 2>> to_north_east;  ///< rad; mean over the runs that show it
  std::array<double, 2> per_face_tilt{};                    ///< as in LevelError, the largest of the runs
  std::string reason;                                       ///< why there is none; empty where there is one
  bool with_headings = false;                               ///< some run knows the headings of all its positions
  bool in_every_run = false;                                ///< each has shown it
};

/// A run that a model was fitted to.
struct RunReference {
  std::string run_id;
  std::string label;
  std::string campaign;
  std::string content_sha256;
};

/// The rows of a unit's thermal fits, ready to be fitted sensor by sensor, and what they were made from.
struct UnitRows {
  std::string unit;
  std::string unit_type;
  std::int32_t epoch = 0;
  bool simulated = false;                ///< some run is
  std::vector<RunReference> runs;        ///< all that were given
  std::vector<ReferenceUse> references;  ///< of the campaigns of the runs
  std::vector<ModelTerm> terms;          ///< accepted; the readings were freed of them, but of `narrow_bump`

  std::array<std::optional<CurveData>, kSensorCount> bias;
  std::array<std::optional<CurveData>, kSensorCount>
      scale;  ///< accelerometers turned up and down, gyros turned at rates
  std::array<std::vector<TypeBInput>, kSensorCount> bias_type_b;
  std::array<std::vector<TypeBInput>, kSensorCount> scale_type_b;
  /// Half the gap between heating and cooling of each bias, for temperatures that were visited one way only: what the
  /// unit's type states.
  std::array<KnownHysteresis, kSensorCount> hysteresis{};
  bool relative_accel = false;                       ///< one attitude: accelerometer bias has no level of its own
  std::array<bool, kSensorCount> own_thermometer{};  ///< as in RunInput: the same in all runs that give the sensor
  Gravity gravity;
  std::array<ConstantValidity, kSensorCount> validity;  ///< of constants, where the rows make no curve
  std::optional<Coupling> accel_misalignment;           ///< rad; diagonal 0
  std::optional<Coupling> gyro_misalignment;            ///< rad; diagonal 0: columns are rates about x, y, z
  std::optional<Coupling> g_sensitivity;                ///< holds what of the Earth's rotation was not subtracted
  EarthRemoval earth_removed = EarthRemoval::none;      ///< in every run
  LevelStatement level;
  std::array<std::optional<StatedValue>, 3> even_order;  ///< K₂ of the accelerometers (SensorEstimate), 1/(m/s²)
  std::vector<Warning> warnings;
};

/// Estimates of every run (six-position estimation per plateau; of sessions in attitudes that nobody knows
/// estimate_attitudes(); 30-second blocks where no run has plateaus) as rows. What movements between rests show of the
/// gyros (estimate_gains()) is in the rows of the sessions that have them.
/// Segments that the data gate rejected, and sensors that it rejected in a segment, are left out; `warnings` says so.
/// Gravity of a site that does not know it comes from the references where they have one. Refuses a unit without runs,
/// or of which the gate leaves nothing, runs that give a sensor over different thermometers, a sensor whose every
/// sample in a run is the same number, runs that give no row, and accelerometers whose readings up and down are not
/// those of gravity to 20 % (wrong sign, unit or position), naming the remedy.
[[nodiscard]] base::Result<UnitRows> make_rows(const UnitInput& input);

}  // namespace soak::calib
