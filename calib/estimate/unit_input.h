// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/estimate/moves.h"
#include "calib/estimate/site.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"

/// What of the recorded runs goes into a fit: each recording once, without what the data gate rejected.
namespace soak::calib {

/// One run of a unit, as a fit takes it.
struct RunInput {
  std::string run_id;
  std::string label;
  std::string campaign;
  std::string content_sha256;
  bool simulated = false;
  Site site;
  std::vector<Segment> segments;
  /// Sensors whose temperatures in the segments are those of a thermometer of their own, not of the unit's.
  std::array<bool, kSensorCount> own_thermometer{};
  std::vector<Move> moves = {};  ///< between its segments, where is_bench_session()
};

/// The sensors of a recorded run that have values and a thermometer of their own. Effects that were taken off the
/// segments (`sensor_lag`) would look like one: ask before.
[[nodiscard]] std::array<bool, kSensorCount> own_thermometers(const std::vector<Segment>& segments);

/// A unit with the runs of one epoch.
struct UnitInput {
  std::string unit;  ///< serial number
  UnitType type;
  std::int32_t epoch = 0;
  std::vector<RunInput> runs;
  std::vector<ReferenceUse> references;  ///< of the campaigns of its runs
  std::vector<ModelTerm> terms;          ///< accepted for the unit; taken off the segments but for `narrow_bump`
};

/// Whether two recordings are the same samples, from the statistics of their segments, which are in the order of time:
/// every segment that both have (the same beginning and end in device time) has the same mean temperature and, of each
/// sensor, the same number of samples, mean and variance, to the last bit; and in one of these segments at least some
/// sensor scatters. Labels, serial number, number types, further columns and void records do not matter. Numbers that
/// were rounded anew, other plateaus and a shifted time are not seen through. Noise does not repeat to the last bit: of
/// two recordings of 90 samples of six sensors this says "the same" practically never.
[[nodiscard]] bool same_samples(std::span<const Segment> a, std::span<const Segment> b);

/// Takes each run of a unit whose samples an earlier one in the list holds already (the same content hash, or
/// same_samples()) out of the list: a fit that took both for independent power-ons would state too little uncertainty,
/// and its held-out folds would have seen what they judge. Adds a warning `copied_runs` for each run that has copies,
/// with their names.
void leave_out_copies(std::vector<RunInput>& runs, std::vector<Warning>& warnings);

/// Whether a fit may not use the segment, or not this sensor of it.
[[nodiscard]] bool is_rejected(const Segment& segment);
[[nodiscard]] bool is_rejected(const Segment& segment, Sensor sensor);

/// The segments that a fit may use; of a sensor that is rejected in a segment, its statistics there (and in the blocks)
/// have count 0.
[[nodiscard]] std::vector<Segment> accepted(std::span<const Segment> segments);

/// One warning per code and severity, over all segments: how many segments it concerns of how many, and the text of the
/// first. In the order in which they come first; empty where there are no findings.
[[nodiscard]] std::vector<Warning> gate_warnings(std::span<const Segment> segments);

/// " (also in 2 more runs)" behind a warning of one run; empty for 0.
[[nodiscard]] std::string more_runs_text(std::size_t more);

/// A run as it is fitted: what the data gate left of it, and where it stood.
struct GatedRun {
  const RunInput* recorded = nullptr;
  std::vector<Segment> segments;  ///< accepted()
  Place place;

  [[nodiscard]] bool in_found_attitudes() const { return std::ranges::any_of(segments, is_found_rest); }
  [[nodiscard]] bool has_plateaus() const {
    return std::ranges::any_of(segments, [](const Segment& segment) { return segment.plateau_c.has_value(); });
  }
};

/// Every run of the unit without what the gate rejected; gravity of a site that does not know it comes from the
/// references where they have one, and rates of the fixture are corrected as they say. `warnings`: one per code, that
/// of the first run that has it, and how many more runs do.
[[nodiscard]] std::vector<GatedRun> gate_runs(const UnitInput& input, std::vector<Warning>& warnings);

}  // namespace soak::calib
