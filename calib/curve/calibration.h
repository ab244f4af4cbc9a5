// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "anfis/model/model.h"
#include "calib/vocabulary/one_way.h"
#include "calib/vocabulary/position.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// Piecewise cubic curve: on [knots_c[k], knots_c[k+1]) the value is Σ_p coefficients[k][p]·(T − knots_c[k])^p. One
/// more knot than pieces. Carries smoothing splines, cubics (one piece) and, sampled finely, quintics.
struct SplineCurve {
  std::vector<double> knots_c;
  std::vector<std::array<double, 4>> coefficients;
};

/// Values at first_c, first_c + step_c, ...; linear between them.
struct TableCurve {
  double first_c = 0.0;
  double step_c = 1.0;
  std::vector<double> values;
  /// Where the table stands for another curve: largest difference between the two over the valid range, in the unit of
  /// the curve (table_form.h).
  std::optional<double> bound = std::nullopt;
};

/// A function of temperature in °C, in SI (bias: rad/s, m/s²) or ppm (scale). A model has temperature as its only
/// input.
using Curve = std::variant<anfis::Model, SplineCurve, TableCurve>;

/// Value of the curve at `temp_c`, in double, clamped to the ends of the curve's own domain (anfis: the range of its
/// input).
[[nodiscard]] double evaluate(const Curve& curve, double temp_c);

/// The same at many temperatures, cheaper than one by one; `values` has the size of `temp_c`.
void evaluate(const Curve& curve, std::span<const double> temp_c, std::span<double> values);

/// Ends of the curve's own domain in °C: beyond them evaluate() holds the curve.
[[nodiscard]] std::array<double, 2> domain_of(const Curve& curve);

/// Uncertainty of a curve on a grid; linear between its points. Units as the curve's.
struct UncertaintyTable {
  std::vector<double> temp_c;
  std::vector<double> ci95;  ///< half-width for the mean curve over runs (two-sided t)
  std::vector<double> pi95;  ///< half-width for one fresh power-on; empty where it has no meaning (scale)
  /// Of one run alone: neither half-width holds the scatter from power-on to power-on, which nobody knows.
  bool one_run = false;
};

/// What the file says of one sensor.
struct SensorCalibration {
  Sensor sensor = Sensor::gyro_x;
  bool own_thermometer = false;  ///< its temperatures are of a thermometer of this sensor, not of the unit's
  double temp_min_c = 0.0;       ///< valid range: that of the training segment means
  double temp_max_c = 0.0;
  std::string model;  ///< what the bias curve is: "anfis", "poly3", "poly5", "spline", "constant", "anfis+narrow_bump"
  Curve bias;
  UncertaintyTable bias_uncertainty;
  std::optional<OneWay> one_way;  ///< temperatures that the runs visited one way only; absent: none, or not stated
  /// Absent where the data cannot give it (static soak of a gyro). Its domain is where it was measured: at most the
  /// valid range.
  std::optional<Curve> scale_ppm;
  std::optional<UncertaintyTable> scale_uncertainty;
};

/// Scale factor error in ppm at a temperature of the valid range; absent where it is not known, or was not measured at
/// this temperature.
[[nodiscard]] std::optional<double> measured_scale_ppm(const SensorCalibration& sensor, double temp_c);

/// A term that `gap accept` added: evaluated by mechanism, its meaning fixed by its name (design: missing effects).
struct AcceptedTerm {
  std::string name;
  bool lab_only = false;  ///< cannot be evaluated from the course of the unit's own temperature
  std::vector<Sensor> sensors;
  std::vector<std::pair<std::string, double>> parameters;
};

/// Standard uncertainties (k = 1) of a matrix of couplings, entry by entry, in the matrix's unit; each at least 0.
struct CouplingUncertainty {
  std::array<Vector3, 3> standard{};
  bool readings_only = false;  ///< from the scatter of the readings; what they do not show (fixture) was not stated

  friend bool operator==(const CouplingUncertainty&, const CouplingUncertainty&) = default;
};

/// Even-order term K₂ of an accelerometer in 1/(m/s²): the reading holds K₂·(f² − g²) along its axis, which no
/// correction takes away.
struct EvenOrderTerm {
  double value = 0.0;
  double standard_uncertainty = 0.0;  ///< k = 1
  bool readings_only = false;         ///< as in CouplingUncertainty

  friend bool operator==(const EvenOrderTerm&, const EvenOrderTerm&) = default;
};

/// All that leaves the lab for one unit.
struct Calibration {
  std::string unit;  ///< serial number
  std::string unit_type;
  std::int32_t epoch = 0;
  std::int32_t model_version = 0;
  double created_utc_s = 0.0;
  bool simulated = false;
  bool unreleased = false;  ///< its laboratory has not released the model: nobody vouches for the file
  double gravity_mps2 = 0.0;
  bool gravity_assumed = true;
  std::vector<ReferenceUse> references;  ///< that its campaigns were measured with
  std::vector<std::string> run_hashes;   ///< content SHA-256 (hex) of every run that the fit used
  std::vector<SensorCalibration> sensors;
  /// Row i: response of accelerometer i to specific force along x, y, z beyond its own scale; diagonal 0. Constant.
  std::optional<std::array<Vector3, 3>> accel_misalignment;
  /// Row i: bias of gyro i per specific force along x, y, z, in (rad/s)/(m/s²). Only where accepted.
  std::optional<std::array<Vector3, 3>> g_sensitivity;
  /// Row i: response of gyro i to rates about x, y, z beyond its own scale; diagonal 0. Constant.
  std::optional<std::array<Vector3, 3>> gyro_misalignment;
  std::optional<CouplingUncertainty> misalignment_uncertainty;       ///< only beside accel_misalignment; diagonal 0
  std::optional<CouplingUncertainty> gyro_misalignment_uncertainty;  ///< only beside gyro_misalignment; diagonal 0
  std::optional<CouplingUncertainty> g_sensitivity_uncertainty;      ///< only beside g_sensitivity
  std::array<std::optional<EvenOrderTerm>, 3> even_order;            ///< of the accelerometers x, y, z
  std::vector<AcceptedTerm> terms;
};

}  // namespace soak::calib
