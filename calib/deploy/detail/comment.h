// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/curve/calibration.h"
#include "calib/deploy/export_loss.h"

namespace soak::calib::exporting {

/// "# text" as a line of its own. Whatever could begin another line or is not printable ASCII becomes '_'.
[[nodiscard]] std::string comment(std::string_view text);

/// A number in fixed notation, as short as it reads back to the same float32: some parameter editors know no exponents.
[[nodiscard]] std::string fixed_text(float value);

/// Comment lines: what made the calibration, from what, measured with which references by which waivers, and a warning
/// where it is simulated.
[[nodiscard]] std::string provenance_comment(const Calibration& calibration);

/// Comment lines: the loss of each sensor, what the scale factor would have needed, and the notes.
[[nodiscard]] std::string loss_comment(const AutopilotFile& file);

}  // namespace soak::calib::exporting
