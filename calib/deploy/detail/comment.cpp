// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/comment.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

#include "base/text.h"

namespace soak::calib::exporting {
namespace {

/// "gyro_x: rms 0.0012, worst 0.003 deg/s at -30 degC, where ...".
std::string loss_text(const CubicLoss& loss) {
  const double factor = printed_per_si(loss.sensor);
  return fmt::format(
      "{}: rms {:.3g}, worst {:.3g} {} at {:.1f} degC, where the model's own 95 % band is +-{:.3g}; beyond that band "
      "in {:.0f} % of the range",
      name_of(loss.sensor), loss.rms * factor, loss.worst * factor, printed_unit(loss.sensor), loss.worst_temp_c,
      loss.ci95_at_worst * factor, 100.0 * loss.beyond_ci95);
}

std::string scale_loss_text(const CubicLoss& loss) {
  if (!loss.scale_ppm) return fmt::format("{}: scale factor error not known", name_of(loss.sensor));
  return fmt::format("{}: scale factor error from {:.0f} to {:.0f} ppm where it was measured", name_of(loss.sensor),
                     (*loss.scale_ppm)[0], (*loss.scale_ppm)[1]);
}

}  // namespace

std::vector<std::string> identity_lines(const Calibration& calibration, const Clean& clean) {
  return {"unit: " + clean(calibration.unit),
          "unit type: " + clean(calibration.unit_type),
          fmt::format("epoch: {}", calibration.epoch),
          fmt::format("model version: {}", calibration.model_version),
          "created: " + base::utc_text(calibration.created_utc_s),
          fmt::format("gravity: {} m/s2{}", base::shortest(calibration.gravity_mps2),
                      calibration.gravity_assumed ? " (assumed)" : "")};
}

std::vector<std::string> source_lines(const Calibration& calibration, const Clean& clean) {
  std::vector<std::string> lines;
  for (const std::string& hash : calibration.run_hashes) lines.push_back("run: " + hash);
  for (const auto& [reference, waiver, campaigns] : calibration.references) {
    lines.push_back(fmt::format("reference: {} {}, certificate {}, issued {}, due {}, standard uncertainty {} {}",
                                name_of(reference.kind), clean(reference.name), clean(reference.certificate),
                                base::utc_text(reference.issued_utc_s), base::utc_text(reference.due_utc_s),
                                base::shortest(printed_per_si(reference.kind) * reference.standard_uncertainty),
                                printed_unit(reference.kind)));
    if (!waiver) continue;
    lines.push_back(fmt::format("  WAIVER, signed {} by {}: {}", base::utc_text(waiver->utc_s), clean(waiver->signer),
                                clean(waiver->reason)));
  }
  return lines;
}

std::string comment(std::string_view text) {
  std::string line = "# ";
  for (const char c : text) line += c < ' ' || c > '~' ? '_' : c;
  return line + '\n';
}

std::string fixed_text(float value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed).ptr;
  return {buffer.data(), end};
}

std::string provenance_comment(const Calibration& calibration) {
  std::string text;
  if (calibration.simulated) text += comment("SIMULATED SIMULATED SIMULATED: made from simulated data. Do not fly it.");
  if (calibration.unreleased) text += comment("NOT RELEASED: its laboratory does not vouch for this calibration.");
  text += comment("Thermal calibration by Soak (docs/deployment.md).");
  const Clean as_it_is = [](std::string words) { return words; };  // comment() leaves no line break in them
  for (const std::string& line : identity_lines(calibration, as_it_is)) text += comment(line);
  for (const std::string& line : source_lines(calibration, as_it_is)) text += comment(line);
  return text;
}

std::string loss_comment(const AutopilotFile& file) {
  std::string text = comment("Loss of these cubics against the model, over the valid range:");
  for (const CubicLoss& loss : file.losses) text += comment("  " + loss_text(loss));
  text += comment("Not carried (the format knows no scale factor over temperature, and no misalignment):");
  for (const CubicLoss& loss : file.losses) text += comment("  " + scale_loss_text(loss));
  text += comment("Left to you:");
  for (const std::string& note : file.notes) text += comment("  - " + note);
  return text;
}

}  // namespace soak::calib::exporting
