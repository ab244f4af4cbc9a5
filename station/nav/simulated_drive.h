// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/curve/calibration.h"
#include "calib/vocabulary/sensor.h"
#include "nav/drive/drive.h"
#include "nav/outages/pipeline.h"
#include "nav/scenario/simulated_errors.h"

/// Drives that never were, over a course of temperature.
namespace soak::station {

/// What to simulate.
struct DriveRequest {
  int duration_s = 600;
  int rate_hz = 100;
  nav::UnitErrors errors;
  nav::TemperatureProfile temperature;
  nav::ThermalBias thermal;  ///< empty: none
  std::uint64_t seed = 1;
};

/// A drive through a town that never was: 40 s of rest, then turns, stops and straights; fixes at 1 Hz, truth at 1 Hz.
[[nodiscard]] nav::Drive simulated_drive(const DriveRequest& request);

/// Bias of sensors over temperature where no unit was measured: a smooth step of 0.5 deg/s for gyros and 0.05 m/s² for
/// accelerometers from −30 to 70 °C [AH05 §6.4.1, figures 6.6, 6.10], the steepest part somewhere else for each sensor.
[[nodiscard]] double example_curve(calib::Sensor sensor, double temp_c);

/// What a calibration leaves of a curve: half_width() as a standard deviation, drawn for each sensor and both ends of
/// the range and straight between them. Of another drive another one.
class CurveResidual {
 public:
  CurveResidual(const calib::Calibration& calibration, std::uint64_t seed);
  [[nodiscard]] double operator()(calib::Sensor sensor, double temp_c) const;

 private:
  struct Part {
    const calib::SensorCalibration* calibration = nullptr;
    double at_low = 0.0;  ///< standard normal numbers
    double at_high = 0.0;
  };
  std::array<Part, calib::kSensorCount> parts_;
};

/// How far the curve of the next power-on may lie from the stated one at a temperature, in SI: the half-width `pi95`
/// (95 %, one fresh power-on), linear between the points of its table. A table without it, of one run, gives `ci95`, in
/// which the scatter from power-on to power-on is missing.
[[nodiscard]] double half_width(const calib::UncertaintyTable& table, double temp_c);

/// The calibration's curve of a sensor in SI; 0 for a sensor that it does not have.
[[nodiscard]] double curve_value(const calib::Calibration& calibration, calib::Sensor sensor, double temp_c);

/// Takes the value of a curve at the sample's temperature off each reading.
[[nodiscard]] nav::Correction curve_correction(nav::ThermalBias curve);

}  // namespace soak::station
