// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/deploy/export.h"

/// The comments of exported files.
namespace soak::calib::exporting {

/// Makes what people wrote (names, reasons) fit for a comment.
using Clean = std::function<std::string(std::string)>;

/// "name: value" of what a calibration is of: unit, type, epoch, version, time, gravity.
[[nodiscard]] std::vector<std::string> identity_lines(const Calibration& calibration, const Clean& clean);

/// What it was made from and measured with: a line for each run and each reference, and one behind the reference,
/// indented, for its waiver.
[[nodiscard]] std::vector<std::string> source_lines(const Calibration& calibration, const Clean& clean);

/// "# text" as a line of its own. Whatever could begin another line or is not printable ASCII becomes '_'.
[[nodiscard]] std::string comment(std::string_view text);

/// A number in fixed notation, as short as it reads back to the same float32: some parameter editors know no exponents.
[[nodiscard]] std::string fixed_text(float value);

/// Comment lines: what made the calibration, from what, measured with which references by which waivers, and a warning
/// where it is simulated or not released.
[[nodiscard]] std::string provenance_comment(const Calibration& calibration);

/// Comment lines: the loss of each sensor, what the scale factor would have needed, and the notes.
[[nodiscard]] std::string loss_comment(const AutopilotFile& file);

}  // namespace soak::calib::exporting
