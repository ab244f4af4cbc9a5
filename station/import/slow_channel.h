// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/recording.h"
#include "db/run/run_file.h"

/// Channels that have a value in some rows only, and the rate of the fixture, which is one of them.
namespace soak::station {

/// Fills rows without a new value (NaN) with the last one, for 2 s at most, or for 1.5 times the median spacing of the
/// channel's own values where that is longer. Rows before the first value stay NaN.
void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values);
/// The same for rows that are part of a run: `limit_s` of the whole one (HoldLimit).
void hold_slow_channel(std::span<const double> t_s, std::vector<double>& values, double limit_s);

/// Gathers from a channel's rows, in order, in pieces of any length, how long its values hold.
class HoldLimit {
 public:
  void add(std::span<const double> t_s, std::span<const double> values);
  [[nodiscard]] double limit_s() const;

 private:
  std::vector<double> long_s_;  ///< distances between values that hold for longer than the least time
  std::size_t distances_ = 0;
  std::optional<double> last_s_;
};

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
