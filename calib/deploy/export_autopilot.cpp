// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "calib/deploy/detail/comment.h"
#include "calib/deploy/detail/cubic_refit.h"
#include "calib/deploy/export.h"

namespace soak::calib {
namespace {

using exporting::TempRange;
using Axes = std::vector<const SensorCalibration*>;

const char* kind_word(bool gyro) { return gyro ? "gyros" : "accelerometers"; }

/// Accepted effects that a device corrects with the calibration file, and no cubic does; nothing without such.
std::optional<std::string> effects_note(const Calibration& calibration) {
  std::vector<std::string> names;
  for (const AcceptedTerm& term : calibration.terms) {
    const bool listed = std::find(names.begin(), names.end(), term.name) != names.end();
    if (!term.lab_only && !listed) names.push_back(term.name);
  }
  if (names.empty()) return std::nullopt;
  return fmt::format(
      "Accepted effects that this file does not hold, or only in part: {}. A cubic over temperature has no "
      "room for them.",
      fmt::join(names, ", "));
}

// ---- PX4 ----

/// The parameters of one axis as PX4 holds them.
struct Px4Cubic {
  std::array<float, 4> x{};
  float t_ref = 0.0F;
  float t_min = 0.0F;
  float t_max = 0.0F;

  /// The offset that PX4 computes: float32, powers first.
  float operator()(float temp_c) const {
    const float d = std::clamp(temp_c, t_min, t_max) - t_ref;
    const float d2 = d * d;
    const float d3 = d2 * d;
    return x[0] + x[1] * d + x[2] * d2 + x[3] * d3;
  }
};

std::string px4_int(const std::string& name, std::int32_t value) {
  return fmt::format("1\t1\t{}\t{}\t6\n", name, value);
}

std::string px4_float(const std::string& name, float value) {
  return fmt::format("1\t1\t{}\t{}\t9\n", name, base::shortest(value));
}

std::string px4_axis(const std::string& prefix, std::size_t axis, const Px4Cubic& cubic) {
  std::string text;
  for (int power = 3; power >= 0; --power) {
    text += px4_float(fmt::format("{}_X{}_{}", prefix, power, axis), cubic.x[static_cast<std::size_t>(power)]);
  }
  return text;
}

/// Adds the losses of one kind to the file; returns its parameter lines.
base::Result<std::string> px4_kind(const Calibration& calibration, bool gyro, const Px4Options& options,
                                   AutopilotFile& file) {
  const auto axes = exporting::three_axes(calibration, gyro, "PX4");
  if (!axes) return base::forward_error(axes);
  if (axes->empty()) return std::string();
  const auto range = exporting::common_range(*axes);
  if (!range) return base::forward_error(range);

  const char letter = gyro ? 'G' : 'A';
  const std::string prefix = fmt::format("TC_{}{}", letter, options.instance);
  const auto t_ref = static_cast<float>(0.5 * (range->min_c + range->max_c));
  Px4Cubic cubic{{}, t_ref, static_cast<float>(range->min_c), static_cast<float>(range->max_c)};
  std::string text = px4_int(fmt::format("TC_{}_ENABLE", letter), 1);
  if (const auto id = gyro ? options.gyro_id : options.accel_id) text += px4_int(prefix + "_ID", *id);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto best = exporting::best_cubic(*(*axes)[axis], *range, t_ref);
    std::transform(best.begin(), best.end(), cubic.x.begin(), [](double c) { return static_cast<float>(c); });
    text += px4_axis(prefix, axis, cubic);
    file.losses.push_back(exporting::loss_of(*(*axes)[axis], *range, t_ref, cubic));
  }
  return text + px4_float(prefix + "_TREF", cubic.t_ref) + px4_float(prefix + "_TMIN", cubic.t_min) +
         px4_float(prefix + "_TMAX", cubic.t_max);
}

std::string px4_id_note(bool gyro, int instance) {
  return fmt::format(
      "No device id was given: set TC_{}{}_ID to the value of CAL_{}n_ID of that sensor; until then PX4 does not apply "
      "these parameters.",
      gyro ? 'G' : 'A', instance, gyro ? "GYRO" : "ACC");
}

std::string px4_level_note(bool gyro, bool relative) {
  if (relative) {
    return "The accelerometers' bias has no level of its own (recorded in one attitude): after loading, restart and "
           "calibrate the accelerometers inside the valid range.";
  }
  return fmt::format(
      "X0 holds the whole bias of the {0}: after loading, restart and calibrate them inside the valid range, or set "
      "CAL_{1}n_*OFF to 0; else the bias is subtracted twice.",
      kind_word(gyro), gyro ? "GYRO" : "ACC");
}

/// PX4 publishes a new offset only after the temperature has moved by more than 1 °C.
std::string px4_step_note(bool gyro, const std::vector<CubicLoss>& losses) {
  double steepest = 0.0;
  for (const CubicLoss& loss : losses) {
    if (is_gyro(loss.sensor) == gyro) steepest = std::max(steepest, loss.steepest_per_c * printed_per_si(loss.sensor));
  }
  return fmt::format(
      "PX4 publishes a new offset only after 1 degC: the correction of the {} may lag by up to {:.2g} {} beyond the "
      "loss above.",
      kind_word(gyro), steepest, printed_unit(gyro ? Sensor::gyro_x : Sensor::accel_x));
}

std::vector<std::string> px4_notes(const Px4Options& options, const std::vector<CubicLoss>& losses) {
  std::vector<std::string> notes;
  for (const bool gyro : {false, true}) {
    if (std::none_of(losses.begin(), losses.end(), [&](const auto& loss) { return is_gyro(loss.sensor) == gyro; })) {
      notes.push_back(fmt::format("The model has no {}: their parameters are left out.", kind_word(gyro)));
      continue;
    }
    if (!(gyro ? options.gyro_id : options.accel_id)) notes.push_back(px4_id_note(gyro, options.instance));
    notes.push_back(px4_level_note(gyro, !gyro && options.relative_accel));
    notes.push_back(px4_step_note(gyro, losses));
  }
  notes.emplace_back(
      "The axes must be those of PX4's sensor_accel and sensor_gyro (FRD board frame, before SENS_BOARD_ROT): at rest "
      "and level its z accelerometer reads about -g. Nothing was turned or negated here.");
  return notes;
}

// ---- ArduPilot ----

constexpr double kArduPilotScale = 1.0e6;  // a stored value is the coefficient times this
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

std::string ardupilot_line(const std::string& name, float value) {
  return fmt::format("{} {}\n", name, exporting::fixed_text(value));
}

ArduPilotCubic ardupilot_cubic(const SensorCalibration& sensor, TempRange range) {
  const auto best = exporting::best_cubic(sensor, range, kArduPilotReference_c);
  ArduPilotCubic cubic;
  cubic.t_min = static_cast<float>(range.min_c);
  cubic.t_max = static_cast<float>(range.max_c);
  for (std::size_t k = 0; k < 3; ++k) cubic.c[k] = static_cast<float>(kArduPilotScale * best[k + 1]);
  cubic.caltemp = std::clamp(static_cast<float>(kArduPilotReference_c), cubic.t_min, cubic.t_max);
  const double d = static_cast<double>(cubic.caltemp) - kArduPilotReference_c;
  cubic.offset = static_cast<float>(best[0] + d * (best[1] + d * (best[2] + d * best[3])));
  return cubic;
}

/// INS_TCALn_ACC1_X ...; zeros where there is no sensor: stale ones would be switched on with the others.
std::string ardupilot_coefficients(int imu, bool gyro, const std::vector<ArduPilotCubic>& cubics) {
  std::string text;
  for (std::size_t power = 1; power <= 3; ++power) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float value = cubics.empty() ? 0.0F : cubics[axis].c[power - 1];
      text += ardupilot_line(fmt::format("INS_TCAL{}_{}{}_{}", imu, gyro ? "GYR" : "ACC", power, kAxisLetters[axis]),
                             value);
    }
  }
  return text;
}

/// INS_ACC2OFFS_X ... and INS_ACC2_CALTEMP; the first instance has no number in the names of its offsets.
std::string ardupilot_offsets(int imu, bool gyro, const std::vector<ArduPilotCubic>& cubics) {
  const char* const kind = gyro ? "GYR" : "ACC";
  const std::string first = gyro ? "INS_GYROFFS" : "INS_ACCOFFS";
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = imu == 1 ? first : fmt::format("INS_{}{}OFFS", kind, imu);
    text += ardupilot_line(fmt::format("{}_{}", name, kAxisLetters[axis]), cubics[axis].offset);
  }
  return text + ardupilot_line(fmt::format("INS_{}{}_CALTEMP", kind, imu), cubics.front().caltemp);
}

/// The lines of one kind; its losses go to the file.
std::string ardupilot_kind(const Axes& axes, bool gyro, TempRange range, const ArduPilotOptions& options,
                           AutopilotFile& file) {
  const int imu = options.instance + 1;
  std::vector<ArduPilotCubic> cubics;
  for (const SensorCalibration* sensor : axes) {
    cubics.push_back(ardupilot_cubic(*sensor, range));
    file.losses.push_back(exporting::loss_of(*sensor, range, kArduPilotReference_c, cubics.back()));
  }
  std::string text = ardupilot_coefficients(imu, gyro, cubics);
  if (!cubics.empty() && (gyro || !options.relative_accel)) text += ardupilot_offsets(imu, gyro, cubics);
  return text;
}

std::vector<std::string> ardupilot_notes(const Axes& gyros, const Axes& accels, const ArduPilotOptions& options) {
  std::vector<std::string> notes;
  const int imu = options.instance + 1;
  for (const bool gyro : {true, false}) {
    if ((gyro ? gyros : accels).empty()) {
      notes.push_back(fmt::format("The model has no {}: their coefficients are 0.", kind_word(gyro)));
    }
  }
  if (!accels.empty() && options.relative_accel) {
    notes.push_back(fmt::format(
        "The accelerometers' bias has no level of its own (recorded in one attitude), so offsets and "
        "INS_ACC{}_CALTEMP are left out: calibrate the accelerometers after loading, inside the valid range.",
        imu));
  } else if (!accels.empty()) {
    notes.push_back(fmt::format(
        "The accelerometers' offsets replace those on the board and belong to INS_ACC{}_CALTEMP: load both "
        "or, to keep a calibration of your own, neither. The scale (INS_ACCnSCAL) stays as it is on the board.",
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
      "about -g. Nothing was turned or negated here.");
  notes.emplace_back("Restart the board after loading: INS_TCALn_ENABLE is read at start-up.");
  return notes;
}

}  // namespace

base::Result<AutopilotFile> export_px4(const Calibration& calibration, const Px4Options& options) {
  if (options.instance < 0 || options.instance >= kPx4Instances) {
    return base::bad_input(fmt::format("PX4 has the instances 0 to {}", kPx4Instances - 1), "--instance");
  }
  AutopilotFile file;
  const auto gyros = px4_kind(calibration, true, options, file);
  if (!gyros) return base::forward_error(gyros);
  const auto accels = px4_kind(calibration, false, options, file);
  if (!accels) return base::forward_error(accels);
  if (file.losses.empty()) return base::bad_input("the model has no sensor", fmt::format("unit {}", calibration.unit));
  file.notes = px4_notes(options, file.losses);
  if (auto note = effects_note(calibration)) file.notes.push_back(*std::move(note));
  file.text =
      "# Onboard parameters for Vehicle 1\n#\n" + exporting::provenance_comment(calibration) +
      exporting::comment("offset = X0 + X1 d + X2 d^2 + X3 d^3, d = T - TREF, T held at [TMIN, TMAX]; rad/s, m/s2") +
      exporting::loss_comment(file) + "#\n# Vehicle-Id Component-Id Name Value Type\n" + *accels + *gyros;
  return file;
}

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
  file.notes = ardupilot_notes(*gyros, *accels, options);
  if (auto note = effects_note(calibration)) file.notes.push_back(*std::move(note));
  const std::string prefix = fmt::format("INS_TCAL{}_", options.instance + 1);
  std::string lines = prefix + "ENABLE 1\n" + ardupilot_line(prefix + "TMIN", static_cast<float>(range->min_c)) +
                      ardupilot_line(prefix + "TMAX", static_cast<float>(range->max_c));
  lines += ardupilot_kind(*gyros, true, *range, options, file);
  lines += ardupilot_kind(*accels, false, *range, options, file);
  file.text = exporting::provenance_comment(calibration) +
              exporting::comment(
                  "p(T) = 1e-6 (C1 d + C2 d^2 + C3 d^3), d = T - 35 degC; taken off: p(T) - p(CALTEMP) + OFFS, "
                  "both T held at [TMIN, TMAX]; rad/s, m/s2") +
              exporting::loss_comment(file) + lines;
  return file;
}

}  // namespace soak::calib
