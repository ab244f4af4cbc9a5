// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/judge/chamber_time.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/run.h"

namespace soak::calib {

/// One stay at a plateau, in device time of its run.
struct PlateauVisit {
  double start_s = 0.0;  ///< first row in position
  double end_s = 0.0;    ///< last row in position
  double plateau_c = 0.0;
  Sweep sweep = Sweep::unknown;
};

/// When a run was where.
struct RunSchedule {
  double begin_s = 0.0;  ///< first recorded row
  std::vector<PlateauVisit> visits;
};

/// The visits of a run in order of time, from its segments in position, those that the data gate rejects included.
[[nodiscard]] RunSchedule schedule_of(const RunInput& run);

/// Index of the visit that covers the time, or −1.
[[nodiscard]] int visit_at(const RunSchedule& schedule, double t_s);

/// Set points of all runs, rising; those within 1 K of the one below are the same.
[[nodiscard]] std::vector<double> set_points(const std::vector<RunSchedule>& runs);

/// Index of the set point nearest to a plateau.
[[nodiscard]] std::size_t nearest_set_point(const std::vector<double>& set_points_c, double plateau_c);

/// Every `step`th of `count` set points, the first and the last always.
[[nodiscard]] std::vector<bool> every(std::size_t count, int step);

/// Which visits of a run an option keeps: those at kept set points, in a kept sweep. The visit before the first of a
/// sweep, from which that starts, belongs to it.
[[nodiscard]] std::vector<bool> kept_visits(const RunSchedule& run, const std::vector<double>& set_points_c,
                                            const std::vector<bool>& kept, Sweeps sweeps);

/// How long a run would have lasted with some of its visits only, in hours.
struct RunHours {
  double most = 0.0;
  double least = 0.0;
};

/// The time before the first visit, the kept visits, and the ways between them. A way is the time from the last row in
/// position to the next one: ramp, settling and soak. Where visits between two kept ones are skipped, the joined way
/// takes at most the sum of the recorded ways between them (no settling saved) and at least the longest of them (no
/// longer ramp). What follows the last visit, and the time without power between runs, are not counted.
[[nodiscard]] RunHours run_hours(const RunSchedule& run, const std::vector<bool>& kept);

}  // namespace soak::calib
