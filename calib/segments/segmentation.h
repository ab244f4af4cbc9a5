// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/segments/standstill.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/segment.h"

namespace soak::calib {

/// A stretch of rows [first, last) in which the temperature stands still.
struct Plateau {
  std::size_t first = 0;
  std::size_t last = 0;
  double temp_c = 0.0;  ///< mean over the stretch
};

/// Finds the plateaus in a temperature history: longest stretches of at least 180 s in which ten-second means stay
/// within 0.6 K. Neighbouring stretches less than 1 K apart are one plateau; a chain of stretches that follow each
/// other without a step between is a slow ramp, not plateaus. `t_s` rises; NaN temperatures are passed over.
[[nodiscard]] std::vector<Plateau> find_plateaus(std::span<const double> t_s, std::span<const double> temp_c);

/// The segments of a recording with their statistics, in the order of time.
struct Segmentation {
  std::vector<Segment> segments;
  std::vector<std::string> warnings;
};

/// Cuts a recording into segments: contiguous soak rows with one plateau and one position. Moving rows and ramps are
/// left out; a gap in time of more than 10 s and 20 sample intervals ends a segment. Plateaus come from `plateau_c`;
/// where that is absent they are found from the temperature (find_plateaus). A recording in which there are none
/// becomes segments without plateau, one per stretch of one position, with blocks of 30 s; otherwise blocks are of one
/// minute (a segment shorter than that has one block).
///
/// **On a bench.** Two kinds of recording are one plateau, at the mean temperature, where no set point is given: one
/// with two positions or more that shows no two plateaus and stays within 5 K; and one without positions of a unit that
/// was turned by hand (show_attitudes()), where each standstill is a segment, called "rest 1", "rest 2"... by its key,
/// without a position, as nobody knows its direction.
///
/// Visits count the plateaus in order; the same set point counts again after the temperature has left it by more than
/// 2 K. Sweep: as recorded, else the sign of the last change of plateau, unknown at the first.
/// Refuses a recording without rows. Cost linear in rows.
[[nodiscard]] base::Result<Segmentation> segment(const Recording& recording);

/// The same for sensors that are in memory one at a time.
class Segmenter {
 public:
  /// Finds the segments and their temperatures. Nobody looks at the recording's own samples; it must stay where it is.
  /// `standstills`: of a bench session (may_be_bench_session()), those that StandstillFinder found; else none.
  [[nodiscard]] static base::Result<Segmenter> begin(const Recording& recording,
                                                     std::span<const Standstill> standstills = {});
  Segmenter(Segmenter&&) noexcept;
  Segmenter& operator=(Segmenter&&) noexcept;
  ~Segmenter();

  /// Puts the statistics of one sensor into all segments: one sample per row, NaN = missing.
  void describe(Sensor sensor, std::span<const double> samples);
  /// Sensors that were not described have count 0. The segments stay where they are in memory.
  [[nodiscard]] Segmentation& result();

 private:
  struct Impl;
  explicit Segmenter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib
