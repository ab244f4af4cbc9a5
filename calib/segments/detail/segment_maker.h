// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calib/segments/segmentation.h"
#include "calib/segments/statistics.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/segment.h"

/// The steps of segmentation (segmentation.cpp), for recordings that are in memory and for those that are read visit by
/// visit (long_run.cpp): the same code, so that both give the same bits.
namespace soak::calib::cutting {

/// Rows [first, last) of one plateau and one position; plateau NaN where there is none.
struct Piece {
  std::size_t first = 0;
  std::size_t last = 0;
  double plateau_c = 0.0;
  std::int32_t position = -1;
};

/// The first rows' times that longest_gap_s() looks at.
inline constexpr std::size_t kTimesLooked = 10001;
/// A longer gap in time ends a segment. `t_s`: at least the first kTimesLooked of the recording.
[[nodiscard]] double longest_gap_s(std::span<const double> t_s);

/// Cuts rows, one after the other, into pieces.
class PieceCutter {
 public:
  PieceCutter(bool with_plateaus, double longest_gap_s)
      : with_plateaus_(with_plateaus), longest_gap_s_(longest_gap_s) {}
  /// `plateau_c` NaN: none; `position` -1: moving.
  void add(double t_s, double plateau_c, std::int32_t position, bool soak);
  /// After all rows.
  [[nodiscard]] std::vector<Piece> finish();

 private:
  void close();

  bool with_plateaus_;
  double longest_gap_s_;
  std::vector<Piece> pieces_;
  Piece piece_;  ///< the open one, if it has rows
  std::size_t row_ = 0;
  double last_t_s_ = 0.0;
};

/// Numbers the visits, attempts and sweeps of the pieces in the order of time.
class Visits {
 public:
  /// Rows [first, last) and a temperature: where the unit was that far from it there, the piece is another visit to the
  /// same plateau. Nothing where that does not matter.
  struct Between {
    std::size_t first = 0;
    std::size_t last = 0;
    double temp_c = 0.0;
  };
  [[nodiscard]] std::optional<Between> between(const Piece& piece) const;
  /// Whether these temperatures are that far.
  [[nodiscard]] static bool went_away(std::span<const double> temp_c, double from_c);
  /// `given`: the sweep that was recorded; `went_away`: between the last piece and this one.
  void assign(const Piece& piece, Sweep given, bool went_away, Segment& segment);

 private:
  std::int32_t visit_ = -1;
  double plateau_c_ = 0.0;
  Sweep sweep_ = Sweep::unknown;
  std::vector<std::int32_t> seen_;
  std::size_t previous_last_ = 0;
  double previous_temp_c_ = 0.0;
};

/// Rows [first, last).
struct Rows {
  std::size_t first = 0;
  std::size_t last = 0;
};
/// Where the samples of a segment lie.
struct Place {
  Rows rows;
  std::vector<Rows> blocks;
  bool temp_gaps = false;  ///< the unit's thermometer has no value in some row
};

/// Makes segments of pieces. Its memory is used again.
class SegmentMaker {
 public:
  /// Temperatures, key (but for what Visits numbers) and blocks of a piece, whose rows are those of `r`; `place` is
  /// filled. Nothing where the thermometer has no value. `at_rest`: it is a standstill, whose position nobody has
  /// named.
  [[nodiscard]] std::optional<Segment> make(const Recording& r, const Piece& piece, bool with_plateaus, bool at_rest,
                                            Place& place);
  /// Puts the statistics of one sensor into a segment; `samples` has one per row of `r`.
  void describe(const Recording& r, const Place& place, Sensor sensor, std::span<const double> samples, double step,
                Segment& segment);

 private:
  [[nodiscard]] Line line(std::span<const double> t_s, std::span<const double> temp_c);
  [[nodiscard]] std::array<double, kSensorCount> sensor_temperatures(const Recording& r, Rows rows, double temp_c);
  void make_blocks(const Recording& r, const Piece& piece, double length_s, Segment& segment, Place& place);
  [[nodiscard]] SensorStatistics describe(std::span<const double> samples, std::span<const double> temp_c, Rows rows,
                                          bool gaps, double step);

  std::vector<double> minutes_;
  std::vector<double> values_;
  std::vector<double> scratch_;
};

/// Output step of a sensor from that of the whole recording (output_step()), as a segment may show one number only; 0
/// where it is none.
[[nodiscard]] double plausible_step(Sensor sensor, double step);

/// What there is to say of the segments; `without_temperature`: pieces that gave none.
void add_warnings(Segmentation& result, std::size_t without_temperature);

}  // namespace soak::calib::cutting
