// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export_ardupilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "calib/deploy/detail/comment.h"
#include "calib/deploy/detail/cubic_refit.h"

namespace soak::calib {
namespace {

using exporting::TempRange;
using Axes = std::vector<const SensorCalibration*>;

constexpr double kScaleFactor = 1.0e6;  // a stored value is the coefficient times this
constexpr std::array<char, 3> kAxisLetters = {'X', 'Y', 'Z'};

/// The parameters of one axis as ArduPilot holds them.
struct ArduPilotCubic {
  std::array<float, 3> c{};
  float offset = 0.0F;
  float caltemp = 0.0F;
  float t_min = 0.0F;
  float t_max = 0.0F;

  /// p(T), in float32 and in ArduPilot's order.
  [[nodiscard]] float polynomial(float temp_c) const {
    const float d = std::clamp(temp_c, t_min, t_max) - static_cast<float>(kArduPilotReference_c);
    return (c[0] + (c[1] + c[2] * d) * d) * d * 1.0e-6F;
  }

  /// What is taken off the raw value.
  float operator()(float temp_c) const { return polynomial(temp_c) - polynomial(caltemp) + offset; }
};

std::string line(const std::string& name, float value) {
  return fmt::format("{} {}\n", name, exporting::fixed_text(value));
}

ArduPilotCubic cubic_of(const SensorCalibration& sensor, TempRange range) {
  const auto best = exporting::best_cubic(sensor, range, kArduPilotReference_c);
  ArduPilotCubic cubic;
  cubic.t_min = static_cast<float>(range.min_c);
  cubic.t_max = static_cast<float>(range.max_c);
  for (std::size_t k = 0; k < 3; ++k) cubic.c[k] = static_cast<float>(kScaleFactor * best[k + 1]);
  cubic.caltemp = std::clamp(static_cast<float>(kArduPilotReference_c), cubic.t_min, cubic.t_max);
  const double d = static_cast<double>(cubic.caltemp) - kArduPilotReference_c;
  cubic.offset = static_cast<float>(best[0] + d * (best[1] + d * (best[2] + d * best[3])));
  return cubic;
}

/// INS_TCALn_ACC1_X ...; zeros where there is no sensor: stale ones would be switched on with the others.
std::string coefficient_lines(int imu, bool gyro, const std::vector<ArduPilotCubic>& cubics) {
  std::string text;
  for (std::size_t power = 1; power <= 3; ++power) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float value = cubics.empty() ? 0.0F : cubics[axis].c[power - 1];
      text += line(fmt::format("INS_TCAL{}_{}{}_{}", imu, gyro ? "GYR" : "ACC", power, kAxisLetters[axis]), value);
    }
  }
  return text;
}

/// INS_ACC2OFFS_X ... and INS_ACC2_CALTEMP; the first instance has no number in the names of its offsets.
std::string offset_lines(int imu, bool gyro, const std::vector<ArduPilotCubic>& cubics) {
  const char* const kind = gyro ? "GYR" : "ACC";
  const std::string first = gyro ? "INS_GYROFFS" : "INS_ACCOFFS";
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = imu == 1 ? first : fmt::format("INS_{}{}OFFS", kind, imu);
    text += line(fmt::format("{}_{}", name, kAxisLetters[axis]), cubics[axis].offset);
  }
  return text + line(fmt::format("INS_{}{}_CALTEMP", kind, imu), cubics.front().caltemp);
}

/// The lines of one kind; its losses go to the file.
std::string kind_lines(const Axes& axes, bool gyro, TempRange range, const ArduPilotOptions& options,
                       AutopilotFile& file) {
  const int imu = options.instance + 1;
  std::vector<ArduPilotCubic> cubics;
  for (const SensorCalibration* sensor : axes) {
    cubics.push_back(cubic_of(*sensor, range));
    file.losses.push_back(exporting::loss_of(*sensor, range, kArduPilotReference_c, cubics.back()));
  }
  std::string text = coefficient_lines(imu, gyro, cubics);
  if (!cubics.empty() && (gyro || !options.relative_accel)) text += offset_lines(imu, gyro, cubics);
  return text;
}

std::vector<std::string> notes_of(const Axes& gyros, const Axes& accels, const ArduPilotOptions& options) {
  std::vector<std::string> notes;
  const int imu = options.instance + 1;
  if (gyros.empty()) notes.emplace_back("The model has no gyros: their coefficients are 0.");
  if (accels.empty()) notes.emplace_back("The model has no accelerometers: their coefficients are 0.");
  if (!accels.empty() && options.relative_accel) {
    notes.push_back(fmt::format(
        "The accelerometers' bias has no level of its own (recorded in one attitude), so offsets and "
        "INS_ACC{}_CALTEMP are left out: calibrate the accelerometers after loading, inside the valid range.",
        imu));
  } else if (!accels.empty()) {
    notes.push_back(
        fmt::format("The accelerometers' offsets replace those on the board and belong to INS_ACC{}_CALTEMP: load both "
                    "or, to keep a "
                    "calibration of your own, neither. The scale (INS_ACCnSCAL) stays as it is on the board.",
                    imu));
  }
  if (!gyros.empty()) {
    notes.push_back(
        fmt::format("With INS_GYR_CAL 1 ArduPilot measures the gyros' offsets and INS_GYR{}_CALTEMP anew at each "
                    "start; those given here hold for INS_GYR_CAL 0.",
                    imu));
  }
  notes.emplace_back(
      "The axes must be those of the board before AHRS_ORIENTATION (FRD): at rest and level its z accelerometer reads "
      "about "
      "-g. Nothing was turned or negated here.");
  notes.emplace_back("Restart the board after loading: INS_TCALn_ENABLE is read at start-up.");
  return notes;
}

}  // namespace

base::Result<AutopilotFile> export_ardupilot(const Calibration& calibration, const ArduPilotOptions& options) {
  if (options.instance < 0 || options.instance >= kArduPilotInstances) {
    return base::bad_input(fmt::format("ArduPilot has the instances 0 to {}", kArduPilotInstances - 1), "--instance");
  }
  const auto gyros = exporting::three_axes(calibration, true, "ArduPilot");
  if (!gyros) return base::forward_error(gyros);
  const auto accels = exporting::three_axes(calibration, false, "ArduPilot");
  if (!accels) return base::forward_error(accels);
  Axes all = *gyros;
  all.insert(all.end(), accels->begin(), accels->end());
  if (all.empty()) return base::bad_input("the model has no sensor", fmt::format("unit {}", calibration.unit));
  const auto range = exporting::common_range(all);
  if (!range) return base::forward_error(range);

  AutopilotFile file;
  file.notes = notes_of(*gyros, *accels, options);
  const std::string prefix = fmt::format("INS_TCAL{}_", options.instance + 1);
  std::string lines = prefix + "ENABLE 1\n" + line(prefix + "TMIN", static_cast<float>(range->min_c)) +
                      line(prefix + "TMAX", static_cast<float>(range->max_c));
  lines += kind_lines(*gyros, true, *range, options, file);
  lines += kind_lines(*accels, false, *range, options, file);
  file.text = exporting::provenance_comment(calibration) +
              exporting::comment(
                  "p(T) = 1e-6 (C1 d + C2 d^2 + C3 d^3), d = T - 35 degC; taken off: p(T) - p(CALTEMP) + OFFS, "
                  "both T held at [TMIN, TMAX]; rad/s, m/s2") +
              exporting::loss_comment(file) + lines;
  return file;
}

}  // namespace soak::calib
