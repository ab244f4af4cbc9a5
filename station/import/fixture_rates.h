// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/recording.h"
#include "db/run/run_file.h"

namespace soak::station {

/// Fastest that a fixture may be said to turn: 3333 turns a minute, several times what rate tables do. At 1 m from the
/// axis that is 12,000 g.
inline constexpr double kFastestFixture_dps = 20000.0;

/// What a position is called while the fixture turns in it: "+Z at 30 deg/s".
[[nodiscard]] std::string label_at_rate(const std::string& label, double rate_dps);

/// Whether a channel gives the rate of the fixture; a foreign column of that name without a unit does not.
[[nodiscard]] bool is_fixture_rate(const db::ChannelInfo& channel);

/// Makes rows of one position at different rates different positions: "+Z at 30 deg/s". `rate_rps` has one value per
/// row and holds as slow channels do; a row at rest (0) keeps its position, one without a rate is "moving". Nothing
/// happens without rates or positions. Refuses (bad_input, naming `run`) more than 100 rates.
[[nodiscard]] base::Status split_by_rate(calib::Recording& recording, std::vector<double> rate_rps,
                                         const std::string& run);

}  // namespace soak::station
