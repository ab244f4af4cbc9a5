// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/gap/report/gap_report.h"
#include "station/gap/gap_comparison.h"

/// What a gap command has to say first, in plain words: what was found, how sure that is, what to do next.
namespace soak::station {

/// A sentence each, on a line of its own.
using ThreeSentences = std::array<std::string, 3>;

/// What a reading unit does that has the effect: "the sensing elements follow the thermometer late". The name itself
/// for one that this program does not know.
[[nodiscard]] std::string effect_words(std::string_view name);

/// "moisture (odds 1 to 40)"; "3 to 1" for one that is the likelier.
[[nodiscard]] std::string rival_text(const calib::gap::Rival& rival);

/// The reason without the notes, which come after the tables.
[[nodiscard]] std::string plain_reason(const calib::gap::GapReport& report);

/// Of a search; `carried`: terms that the model has already.
[[nodiscard]] ThreeSentences sentences_of(const calib::gap::GapReport& report,
                                          const std::vector<calib::ModelTerm>& carried);

/// Effects with their sizes, for a sentence: "the sensing elements follow the thermometer late (sensor_lag: 312 s, tau
/// 320 s, all sensors)". `lines`: size_lines() of each term.
[[nodiscard]] std::string terms_words(const std::vector<calib::ModelTerm>& terms,
                                      const std::vector<std::vector<std::string>>& lines);

/// Of a comparison of before and after. `effects`: terms_words() of its terms.
[[nodiscard]] ThreeSentences sentences_of(const GapComparison& comparison, const std::string& effects);

}  // namespace soak::station
