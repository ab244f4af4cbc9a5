// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/allan.h"

namespace soak::calib::signal {

/// Overlapping Allan, modified Allan and overlapping Hadamard deviations of a record of any length in one pass and
/// bounded memory. Up to a multiple of kExact every overlapping difference counts, as in allan_point(). Beyond, the
/// record is thinned by powers of two (phase for Allan and Hadamard, means of phase for modified Allan) such that
/// differences start at every 2^j-th sample, at least kExact/2 of them per averaging time: the estimate is that of the
/// same quantity with practically the same degrees of freedom. Gaps as in PhaseRecord.
class AllanStream {
 public:
  static constexpr std::size_t kExact = 4096;

  /// Refuses a rate_hz that is not finite and positive.
  [[nodiscard]] static base::Result<AllanStream> create(double rate_hz, std::size_t bridge = PhaseRecord::kBridge);
  AllanStream(AllanStream&&) noexcept;
  AllanStream& operator=(AllanStream&&) noexcept;
  ~AllanStream();

  /// The next samples, NaN where one is missing. Refuses infinite ones, naming the index in the record.
  [[nodiscard]] base::Status push(std::span<const double> rate);

  /// Deviations so far at the averaging times that have at least one difference, rising. May be asked at any time.
  struct Point {
    std::size_t multiple = 0;
    double overlapping = 0.0;
    double modified = 0.0;  ///< NaN where there is none yet
    double overlapping_hadamard = 0.0;
    std::size_t terms = 0;  ///< of the overlapping Allan deviation
  };
  [[nodiscard]] std::vector<Point> points() const;
  [[nodiscard]] const GapReport& gaps() const;
  /// Phase points of each stretch so far.
  [[nodiscard]] const std::vector<std::size_t>& stretches() const;

 private:
  struct Impl;
  explicit AllanStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib::signal
