// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal {

/// The deviations of the Allan family [NIST SP 1065 §5.2]: plain and overlapping Allan, modified Allan, plain and
/// overlapping Hadamard.
enum class AllanKind { plain, overlapping, modified, hadamard, overlapping_hadamard };

/// Samples without a gap.
struct Stretch {
  std::size_t first = 0;  ///< index of the first phase point
  std::size_t count = 0;  ///< phase points: one more than rate samples
};

/// What was done about missing samples.
struct MissingSamples {
  std::size_t missing = 0;  ///< samples that are NaN
  std::size_t bridged = 0;  ///< of these, filled by a straight line because their gap is short
  std::size_t gaps = 0;     ///< gaps too long for that: each has ended a stretch
};

/// A record as phase, the running sum of the rate in units of one sample interval, stretch by stretch. A gap of up to
/// `bridge` NaN samples is filled by a straight line between its neighbours (it changes a mean over m samples by about
/// gap/m of the noise); a longer one ends the stretch: no difference ever reaches across it, and the sums of squares
/// and the numbers of terms of all stretches are added up. What is missing before the first sample or after the last is
/// never bridged. The first value is taken off every rate (no deviation depends on a constant rate, but its
/// running sum would cost digits); each stretch begins at 0, and every point is the exact sum rounded once. Memory: one
/// double per sample.
class PhaseRecord {
 public:
  static constexpr std::size_t kBridge = 5;

  /// From rate samples, NaN where one is missing. Refuses a rate_hz that is not finite and positive, infinite samples,
  /// and a record without two samples in a row.
  [[nodiscard]] static base::Result<PhaseRecord> from_rate(std::span<const double> rate, double rate_hz,
                                                           std::size_t bridge = kBridge);
  /// From phase (angle) points in U*s, NaN where one is missing (these always end a stretch).
  [[nodiscard]] static base::Result<PhaseRecord> from_phase(std::span<const double> phase, double rate_hz);

  [[nodiscard]] double interval_s() const { return interval_s_; }
  [[nodiscard]] std::span<const double> phase() const { return phase_; }
  [[nodiscard]] std::span<const Stretch> stretches() const { return stretches_; }
  [[nodiscard]] const MissingSamples& gaps() const { return gaps_; }
  /// Largest multiple of the interval for which some difference of this kind exists; 0: none.
  [[nodiscard]] std::size_t longest(AllanKind kind) const;

 private:
  double interval_s_ = 1.0;
  std::vector<double> phase_;
  std::vector<Stretch> stretches_;
  MissingSamples gaps_;
};

/// One deviation.
struct AllanPoint {
  std::size_t multiple = 0;  ///< averaging time in sample intervals
  double deviation = 0.0;    ///< in the unit of the rate; NaN where `terms` is 0
  std::size_t terms = 0;     ///< differences that were averaged
};

/// The deviation at one averaging time, exactly as defined (every difference that overlaps). O(n), whatever the
/// multiple; the instruction set is chosen at run time, the same bits on each. Averaging times are independent: a
/// caller with several threads may share them out.
[[nodiscard]] AllanPoint allan_point(const PhaseRecord& record, AllanKind kind, std::size_t multiple);

/// The same for several averaging times, bit for bit, and faster than one by one: they share what has come into the
/// processor's cache (modified Allan up to a multiple of 4096).
[[nodiscard]] std::vector<AllanPoint> allan_points(const PhaseRecord& record, AllanKind kind,
                                                   std::span<const std::size_t> multiples);

/// Whole multiples from 1 to `longest`, both included, rising, spaced as evenly on a logarithmic scale as whole numbers
/// can be; none for `longest` = 0.
[[nodiscard]] std::vector<std::size_t> log_spaced_multiples(std::size_t longest, std::size_t per_decade);

}  // namespace soak::calib::signal
