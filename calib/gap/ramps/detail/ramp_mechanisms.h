// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/gap/effects/effect.h"
#include "calib/gap/observations/temperature_history.h"
#include "calib/gap/ramps/detail/ramp_recording.h"

namespace soak::calib::gap::reduced {

/// One form of a mechanism in a recording without plateaus.
struct Shape {
  std::string text;
  std::vector<double> values;
  /// Regressors, one row per observation; or, where `shifts`, the kelvins by which the curve is read elsewhere.
  Eigen::MatrixXd columns;
  bool shifts = false;
};

/// How a magnitude is read off the parameters of a shape.
enum class Size { largest, first, time_constant };

/// An effect of the library that follows time, temperature or a logged channel, with the forms that are tried.
struct Mechanism {
  const Effect* effect = nullptr;
  std::string per = {};  ///< what follows the printed unit in its magnitude, "/V"
  Size size = Size::first;
  bool shared = false;    ///< one shape for all sensors
  bool nuisance = false;  ///< never named: forbids names where it does as well
  std::vector<Shape> shapes = {};
};

/// Mechanisms whose channels were recorded: temperature_rate (the thermometer's slope, or the difference to a second
/// thermal node that follows with a time constant of 30 to 960 s), sensor_lag (−240 to 960 s), thermal_hysteresis
/// (widths of 2 to 70 K), warmup_transient, a straight drift in time as nuisance, supply_sensitivity,
/// vibration_rectification. Lag, second node and memory start each run at rest or under way, on either branch.
[[nodiscard]] std::vector<Mechanism> mechanisms(const RampRecording& recording, const Courses& courses);

}  // namespace soak::calib::gap::reduced
