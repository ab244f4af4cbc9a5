// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/gap/report/gap_report.h"
#include "station/gap/gap_comparison.h"
#include "station/report/gap_words.h"

/// What `soak gap` prints: three sentences of plain result first, then evidence, tables and reasons.
namespace soak::station {

/// Slow noise as a table, a row for each sensor, with the bias instability at rest beside it; empty without any.
[[nodiscard]] std::string slow_noise_table(const std::vector<calib::gap::SensorWander>& wanders);

/// Of a search: `soak gap find`. `carried`: terms that the model has already.
[[nodiscard]] std::string find_text(const calib::gap::GapReport& report, const std::vector<calib::ModelTerm>& carried);

/// The sizes of each term (size_lines()), and where it is corrected.
[[nodiscard]] std::string terms_text(const std::vector<calib::ModelTerm>& terms,
                                     const std::vector<std::vector<std::string>>& sizes);

/// Of a comparison: `soak gap show`. `sizes`: size_lines() of its terms.
[[nodiscard]] std::string show_text(const GapComparison& comparison, const ThreeSentences& sentences,
                                    const std::vector<std::vector<std::string>>& sizes);

}  // namespace soak::station
