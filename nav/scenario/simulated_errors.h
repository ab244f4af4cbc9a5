// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "nav/drive/drive.h"

namespace soak::nav {

/// Errors of a kind of sensor, in U = rad/s or m/s².
struct SensorErrors {
  double power_on_sigma = 0.0;  ///< constant of a power-on
  double markov_sigma = 0.0;    ///< first-order Gauss-Markov process
  double markov_time_s = 100.0;
  double white = 0.0;  ///< angle or velocity random walk in U·sqrt(s): the root of the two-sided density, U/sqrt(Hz)
  double scale_sigma = 0.0;   ///< 1 = 100 %
  double nonlinearity = 0.0;  ///< error at full range as a share of it; the error grows with the square
  double range = 1.0;         ///< full range, in U
  double step = 0.0;          ///< of the output, in U; 0: no steps
};

/// Errors of a unit; in tables of makers "less than L" is taken for 2 σ = L.
struct UnitErrors {
  std::string name;
  SensorErrors gyro;
  SensorErrors accel;
};

/// Crossbow AHRS400CA [AH05 table 6.1]; in-run bias not in the table: 0.03 deg/s and 1 mg over 100 s are taken.
[[nodiscard]] UnitErrors ahrs400ca();
/// Systron Donner MotionPak II [AH05 table 6.2]; the table gives noise in mV without the sensitivity: 2.5 V at full
/// range and the smallest value of the table are taken, in-run bias as for the AHRS400CA.
[[nodiscard]] UnitErrors motionpak2();
/// ISI unit of the road test [AH05 table 7.1]; the units of its random walks are lost in print: deg/sqrt(h) and
/// m/s/sqrt(h), as in table 6.1, are taken. Bias short term: Gauss-Markov over 100 s.
[[nodiscard]] UnitErrors isi();

/// What temperature adds to a sensor's bias, in U.
using ThermalBias = std::function<double(calib::Sensor sensor, double temp_c)>;

/// Temperature that tends from one value to another.
struct TemperatureProfile {
  double start_c = 20.0;
  double end_c = 20.0;
  double time_s = 300.0;  ///< after which 63 % of the way is done
  [[nodiscard]] double at(double t_s) const;
};

/// Adds the errors to readings at a constant rate, and writes the temperatures. The seed decides.
void add_errors(std::vector<ImuSample>& samples, const UnitErrors& errors, const TemperatureProfile& temperature,
                const ThermalBias& thermal, std::uint64_t seed);

/// White errors of a receiver, standard deviations.
struct GnssErrors {
  double horizontal_m = 0.02;
  double vertical_m = 0.04;
  double horizontal_mps = 0.03;
  double vertical_mps = 0.05;
};

/// Fixes at every `every`-th point of the truth. The seed decides.
[[nodiscard]] std::vector<GnssFix> simulated_fixes(const std::vector<TruthPoint>& truth, std::size_t every,
                                                   const GnssErrors& errors, std::uint64_t seed);

}  // namespace soak::nav
