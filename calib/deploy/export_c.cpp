// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/hash.h"
#include "base/text.h"
#include "calib/deploy/calibration_file.h"
#include "calib/deploy/detail/comment.h"

namespace soak::calib {
namespace {

constexpr std::size_t kBytesPerLine = 16;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// `text` as the tail of a C identifier.
std::string identifier(std::string text) {
  std::replace_if(text.begin(), text.end(), [](char c) { return !is_letter(c) && !is_digit(c); }, '_');
  return text;
}

/// `text` as it may stand in a comment: printable ASCII that can neither end the comment nor splice lines.
std::string comment_text(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return c < ' ' || c > '~' || c == '*' || c == '/' || c == '\\' || c == '?'; }, '_');
  return text;
}

/// What the file knows of a sensor's scale factor, and where.
std::string scale_text(const SensorCalibration& sensor) {
  if (!sensor.scale_ppm) return ", scale unknown";
  const auto [low_c, high_c] = domain_of(*sensor.scale_ppm);
  if (low_c <= sensor.temp_min_c && high_c >= sensor.temp_max_c) return ", with scale";
  return ", scale measured from " + base::shortest(low_c) + " to " + base::shortest(high_c) + " degC only";
}

/// What the half-widths of a sensor do not hold.
std::vector<std::string> band_lines(const SensorCalibration& sensor) {
  std::vector<std::string> lines;
  if (sensor.bias_uncertainty.one_run) {
    lines.emplace_back("  of one run: its uncertainty does not hold the scatter from power-on to power-on");
  }
  if (sensor.one_way) {
    for (const OneWayRange& range : sensor.one_way->ranges) {
      lines.push_back(std::string("  ") + (range.sweep == Sweep::up ? "heating" : "cooling") + " only from " +
                      base::shortest(range.low_c) + " to " + base::shortest(range.high_c) + " degC: " +
                      (sensor.one_way->known.source == HysteresisSource::none
                           ? "its uncertainty does not hold the thermal hysteresis"
                           : std::string("its uncertainty holds the thermal hysteresis of the ") +
                                 std::string(name_of(sensor.one_way->known.source))));
    }
  }
  return lines;
}

std::string head_comment(const Calibration& calibration) {
  std::string text = "/*\n";
  if (calibration.simulated) text += " * SIMULATED SIMULATED SIMULATED: made from simulated data. Do not deploy.\n *\n";
  if (calibration.unreleased) text += " * NOT RELEASED: its laboratory does not vouch for this calibration.\n *\n";
  const auto add = [&](const std::string& line) { text.append(" * ").append(line).append("\n"); };
  add("Thermal calibration by Soak (format: docs/blob-format.md).");
  for (const std::string& line : exporting::identity_lines(calibration, comment_text)) add(line);
  for (const SensorCalibration& sensor : calibration.sensors) {
    add(std::string(name_of(sensor.sensor)) + ": " + comment_text(sensor.model) + ", valid from " +
        base::shortest(sensor.temp_min_c) + " to " + base::shortest(sensor.temp_max_c) + " degC" + scale_text(sensor) +
        (sensor.own_thermometer ? ", over a thermometer of its own" : ""));
    for (const std::string& line : band_lines(sensor)) add(line);
  }
  for (const std::string& line : exporting::source_lines(calibration, comment_text)) add(line);
  return text;
}

std::string usage_comment(const std::string& symbol, bool own_thermometers) {
  std::string text =
      " *\n * Use:\n"
      " *   static soak_cal cal;\n"
      " *   float out[6];\n"
      " *   uint32_t flags;\n";
  text.append(" *   if (soak_load(&cal, ").append(symbol).append(", sizeof ").append(symbol);
  text += ") != SOAK_OK) { no calibration }\n";
  // Of one temperature soak_apply could make nothing for the sensors with thermometers of their own.
  if (own_thermometers)
    text += " *   const float temps_c[6] = {each sensor's thermometer, its own where it has one};\n";
  text.append(" *   if (").append(own_thermometers ? "soak_apply_temps(&cal, temps_c" : "soak_apply(&cal, temp_c");
  return text + ", raw, out, &flags) != SOAK_OK) { flags: which sensor, and why }\n */\n";
}

std::string array_text(const base::Bytes& bytes, const std::string& symbol) {
  std::string text =
      "static const uint8_t " + symbol + "[" + std::to_string(bytes.size()) + "] SOAK_CALIBRATION_ALIGNED = {";
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    text += i % kBytesPerLine == 0 ? "\n    0x" : " 0x";
    text += base::to_hex({bytes.data() + i, 1});
    if (i + 1 < bytes.size()) text += ',';
  }
  return text + "};\n";
}

}  // namespace

base::Result<std::string> export_c(const Calibration& calibration) {
  const auto bytes = encode(calibration);
  if (!bytes) return base::forward_error(bytes);
  const std::string symbol = "soak_calibration_" + identifier(calibration.unit);
  const std::string guard = "SOAK_CALIBRATION_" + identifier(calibration.unit) + "_H_";
  std::string text =
      head_comment(calibration) +
      usage_comment(symbol, std::ranges::any_of(calibration.sensors, &SensorCalibration::own_thermometer));
  text += "#ifndef " + guard + "\n#define " + guard + "\n\n#include \"soak_runtime.h\"\n\n";
  if (calibration.simulated) {
    text +=
        "#ifndef SOAK_ACCEPT_SIMULATED\n"
        "#error \"SIMULATED calibration: define SOAK_ACCEPT_SIMULATED to build it all the same\"\n"
        "#endif\n\n";
  }
  if (calibration.unreleased) {
    text +=
        "#ifndef SOAK_ACCEPT_UNRELEASED\n"
        "#error \"Calibration that is not released: define SOAK_ACCEPT_UNRELEASED to build it all the same\"\n"
        "#endif\n\n";
  }
  text +=
      "#if defined(__GNUC__) || defined(__clang__)\n"
      "#define SOAK_CALIBRATION_ALIGNED __attribute__((aligned(4)))\n"
      "#else\n"
      "#define SOAK_CALIBRATION_ALIGNED\n"
      "#endif\n\n";
  text += array_text(*bytes, symbol);
  return text + "\n#undef SOAK_CALIBRATION_ALIGNED\n#endif\n";
}

}  // namespace soak::calib
