// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/campaign/campaign.h"
#include "calib/vocabulary/position.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib::gap {

/// One block (a minute) of one segment: a row of every test of the gap workflow. Plateau means would not do: with
/// them a term in dT/dt explains nearly all of a true hysteresis.
struct Observation {
  int run = 0;        ///< index into Observations::runs
  int visit = 0;      ///< ordinal of the plateau in the run
  int placement = 0;  ///< ordinal of the segment over all runs: from one turn of the fixture to the next
  int order = 0;      ///< ordinal of the placement in its visit
  int block = 0;      ///< ordinal of the block in its placement
  int level = 0;      ///< index into Observations::level_c
  int cell = 0;       ///< equal for what replicate runs repeat: level, sweep, occurrence of both in the run, position
  int position = -1;  ///< index into Observations::positions
  int previous = -1;  ///< position of the placement before, in the same run
  Sweep sweep = Sweep::unknown;
  Vector3 up{};  ///< zero where the position is not known
  double t_s = 0.0;
  double t_in_placement_s = 0.0;
  double temp_c = 0.0;
  std::array<double, kSensorCount> sensor_temp_c{};
  std::array<SensorStatistics, kSensorCount> sensor;
};

/// The blocks of a campaign in soak phases at plateaus, in the order of runs and time.
struct Observations {
  std::vector<std::string> runs;  ///< labels
  std::vector<std::string> run_ids;
  std::vector<std::size_t> logged;  ///< index of each run in LoggedCampaign::runs
  std::vector<double> level_c;      ///< mean temperature of the rows at each set point, rising
  std::vector<Position> positions;
  std::vector<Observation> rows;
  double gravity_mps2 = 0.0;
  int sign_at_rest = 1;
  bool earth_taken_off = false;  ///< whether a known latitude took the Earth's rotation off the gyros of some run

  [[nodiscard]] bool has_positions() const { return positions.size() > 1; }
  [[nodiscard]] int run_count() const { return static_cast<int>(runs.size()); }
  [[nodiscard]] int level_count() const { return static_cast<int>(level_c.size()); }
  /// Specific force of a row along a body axis in units of g, signed as the unit reads it.
  [[nodiscard]] double force_g(const Observation& row, std::size_t axis) const {
    return sign_at_rest * row.up.at(axis);
  }
};

/// "gyro_x, accel_z".
[[nodiscard]] std::string list_of(const std::vector<Sensor>& sensors);

/// Whether a segment is at rest at a plateau and the data gate (data_gate.h) accepts it.
[[nodiscard]] bool is_observed(const Segment& segment);

/// Index of the level that is nearest to a temperature, the first of those alike.
[[nodiscard]] std::size_t nearest_level(const std::vector<double>& level_c, double temp_c);

/// Segments of all runs as rows, without those that the data gate rejected, those in which the fixture turns and those
/// of phase ramp. What is known of the Earth's rotation (its vertical part by the latitude, all of it where every
/// heading is known too) is taken off the gyros, as the fit does. Runs without any such row are passed over and the
/// others numbered anew (`logged`).
[[nodiscard]] Observations observe(const LoggedCampaign& campaign);

/// Readings of one run that the data gate keeps out of the search.
struct GateRejection {
  std::string run;               ///< label
  std::optional<Sensor> sensor;  ///< absent = whole segments; those are not counted for their sensors again
  std::size_t segments = 0;      ///< that are rejected
  std::size_t of = 0;            ///< soak segments of the run
  std::string code;              ///< of the first finding that rejects
  std::string why;               ///< its sentence
};

/// All that the gate rejected, in the order of runs: whole segments first, then sensors.
[[nodiscard]] std::vector<GateRejection> rejected_by_gate(const LoggedCampaign& campaign);

/// The first three in words, and how many more there are.
[[nodiscard]] std::string in_words(const std::vector<GateRejection>& rejections);

/// Whether more than half of the segments of a run are rejected.
[[nodiscard]] bool mostly_rejected_run(const std::vector<GateRejection>& rejections);

}  // namespace soak::calib::gap
