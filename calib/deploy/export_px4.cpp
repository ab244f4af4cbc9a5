// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export_px4.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/text.h"
#include "calib/deploy/detail/comment.h"
#include "calib/deploy/detail/cubic_refit.h"

namespace soak::calib {
namespace {

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

std::string int_line(const std::string& name, std::int32_t value) {
  return fmt::format("1\t1\t{}\t{}\t6\n", name, value);
}

std::string float_line(const std::string& name, float value) {
  return fmt::format("1\t1\t{}\t{}\t9\n", name, base::shortest(value));
}

std::string axis_lines(const std::string& prefix, std::size_t axis, const Px4Cubic& cubic) {
  std::string text;
  for (int power = 3; power >= 0; --power) {
    text += float_line(fmt::format("{}_X{}_{}", prefix, power, axis), cubic.x[static_cast<std::size_t>(power)]);
  }
  return text;
}

/// Adds the losses of one kind to the file; returns its parameter lines.
base::Result<std::string> kind_lines(const Calibration& calibration, bool gyro, const Px4Options& options,
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
  std::string text = int_line(fmt::format("TC_{}_ENABLE", letter), 1);
  if (const auto id = gyro ? options.gyro_id : options.accel_id) text += int_line(prefix + "_ID", *id);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto best = exporting::best_cubic(*(*axes)[axis], *range, t_ref);
    std::transform(best.begin(), best.end(), cubic.x.begin(), [](double c) { return static_cast<float>(c); });
    text += axis_lines(prefix, axis, cubic);
    file.losses.push_back(exporting::loss_of(*(*axes)[axis], *range, t_ref, cubic));
  }
  return text + float_line(prefix + "_TREF", cubic.t_ref) + float_line(prefix + "_TMIN", cubic.t_min) +
         float_line(prefix + "_TMAX", cubic.t_max);
}

std::string id_note(bool gyro, int instance) {
  return fmt::format(
      "No device id was given: set TC_{}{}_ID to the value of CAL_{}n_ID of that sensor; until then PX4 does not apply "
      "these parameters.",
      gyro ? 'G' : 'A', instance, gyro ? "GYRO" : "ACC");
}

std::string level_note(bool gyro, bool relative) {
  if (relative) {
    return "The accelerometers' bias has no level of its own (recorded in one attitude): after loading, restart and "
           "calibrate the accelerometers inside the valid range.";
  }
  return fmt::format(
      "X0 holds the whole bias of the {0}: after loading, restart and calibrate them inside the valid range, or set "
      "CAL_{1}n_*OFF to 0; else the bias is subtracted twice.",
      gyro ? "gyros" : "accelerometers", gyro ? "GYRO" : "ACC");
}

/// PX4 publishes a new offset only after the temperature has moved by more than 1 °C.
std::string step_note(bool gyro, const std::vector<CubicLoss>& losses) {
  double steepest = 0.0;
  for (const CubicLoss& loss : losses) {
    if (is_gyro(loss.sensor) == gyro) steepest = std::max(steepest, loss.steepest_per_c * printed_per_si(loss.sensor));
  }
  return fmt::format(
      "PX4 publishes a new offset only after 1 degC: the correction of the {} may lag by up to {:.2g} {} beyond the "
      "loss "
      "above.",
      gyro ? "gyros" : "accelerometers", steepest, printed_unit(gyro ? Sensor::gyro_x : Sensor::accel_x));
}

std::vector<std::string> notes_of(const Px4Options& options, const std::vector<CubicLoss>& losses) {
  std::vector<std::string> notes;
  for (const bool gyro : {false, true}) {
    if (std::none_of(losses.begin(), losses.end(), [&](const auto& loss) { return is_gyro(loss.sensor) == gyro; })) {
      notes.push_back(
          fmt::format("The model has no {}: their parameters are left out.", gyro ? "gyros" : "accelerometers"));
      continue;
    }
    if (!(gyro ? options.gyro_id : options.accel_id)) notes.push_back(id_note(gyro, options.instance));
    notes.push_back(level_note(gyro, !gyro && options.relative_accel));
    notes.push_back(step_note(gyro, losses));
  }
  notes.emplace_back(
      "The axes must be those of PX4's sensor_accel and sensor_gyro (FRD board frame, before SENS_BOARD_ROT): at rest "
      "and "
      "level its z accelerometer reads about -g. Nothing was turned or negated here.");
  return notes;
}

}  // namespace

base::Result<AutopilotFile> export_px4(const Calibration& calibration, const Px4Options& options) {
  if (options.instance < 0 || options.instance >= kPx4Instances) {
    return base::bad_input(fmt::format("PX4 has the instances 0 to {}", kPx4Instances - 1), "--instance");
  }
  AutopilotFile file;
  const auto gyros = kind_lines(calibration, true, options, file);
  if (!gyros) return base::forward_error(gyros);
  const auto accels = kind_lines(calibration, false, options, file);
  if (!accels) return base::forward_error(accels);
  if (file.losses.empty()) return base::bad_input("the model has no sensor", fmt::format("unit {}", calibration.unit));
  file.notes = notes_of(options, file.losses);
  file.text =
      "# Onboard parameters for Vehicle 1\n#\n" + exporting::provenance_comment(calibration) +
      exporting::comment("offset = X0 + X1 d + X2 d^2 + X3 d^3, d = T - TREF, T held at [TMIN, TMAX]; rad/s, m/s2") +
      exporting::loss_comment(file) + "#\n# Vehicle-Id Component-Id Name Value Type\n" + *accels + *gyros;
  return file;
}

}  // namespace soak::calib
