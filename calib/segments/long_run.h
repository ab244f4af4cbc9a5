// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/segments/data_gate.h"
#include "calib/segments/segmentation.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"

/// Segments of a run that is too long for the memory: 35 hours at 200 Hz are 25 million rows.
namespace soak::calib {

/// Rows of one unit in one run, read stretch by stretch. Whoever reads them may ask for any rows, any number of times.
class RunRows {
 public:
  RunRows() = default;
  RunRows(const RunRows&) = delete;
  RunRows& operator=(const RunRows&) = delete;
  virtual ~RunRows() = default;

  [[nodiscard]] virtual std::size_t rows() const = 0;
  /// The rows [first, last) as a recording of their own, without the sensors' samples: exactly what the whole recording
  /// holds there. Positions may stand in another order in each, and only those that occur.
  [[nodiscard]] virtual base::Result<Recording> axes(std::size_t first, std::size_t last) = 0;
  [[nodiscard]] virtual bool has(Sensor sensor) const = 0;
  /// One sensor's samples of the rows [first, last), into memory that is used again.
  [[nodiscard]] virtual base::Status samples(Sensor sensor, std::size_t first, std::size_t last,
                                             std::vector<double>& values) = 0;
};

/// A long run's segments with their findings.
struct LongRun {
  Segmentation segmentation;
  double duration_s = 0.0;  ///< from the first row to the last
};

/// Segments with statistics and findings as segment() and examine() give them for the whole recording, to the last bit,
/// with the rows of one segment in memory at a time (and some 100,000 samples of each sensor). The samples are read
/// three times. `visit_channel`: name of an auxiliary channel that numbers the visits (number_visits()).
///
/// Nothing, where that needs the whole recording in memory: no set points, no positions, no rows, or thermometers of
/// single sensors. Fails as `rows` does.
[[nodiscard]] base::Result<std::optional<LongRun>> describe_long_run(RunRows& rows, const UnitType& type,
                                                                     std::string_view visit_channel,
                                                                     const GateLimits& limits = {});

/// Numbers the visits as `visits` (one value per segment, NaN = as it is) says, and the attempts of each position anew.
void number_visits(std::span<const double> visits, std::vector<Segment>& segments);

}  // namespace soak::calib
