// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/allan/allan.h"

namespace soak::calib::signal {

/// Overlapping Allan, modified Allan and overlapping Hadamard deviations of a record of any length in one pass and
/// bounded memory: at most 7 MB, and 8 bytes for each stretch.
///
/// Averaging times are the multiples 1, 2, 3 and then 4, 5, 6 and 7 times 2^k for k = 0, 1, ..: all whole multiples up
/// to 8, then four to an octave (13 to a decade), up to 4096 * 2^23 (3.4e10) samples. Up to kExact every overlapping
/// difference counts: the same bits as allan_point(). Beyond, at a multiple in (2^(j-1), 2^j] * kExact, differences
/// start at every 2^j-th sample, that is at least 2560 of them per averaging time: every 2^j-th phase point for Allan
/// and Hadamard; for modified Allan means of 2^j phase points, which make the same windows. The estimate is that of the
/// same quantity. For white rate noise and noises slower than it, it differs from that of all beginnings by about
///   d/(2T) sqrt(3 + T/m)  of itself (one standard deviation), d = 2^j <= m/2560, T = samples - 2m:
/// 4e-4 at T = m. Where white phase noise (quantisation) still dominates beyond kExact, neighbouring differences are
/// independent and those left out are missed: the standard error of the deviation is then up to 2 %.
///
/// The sizes of the pieces that push() gets do not change a bit. Gaps, bridging and the first value's removal as in
/// PhaseRecord; a gap at the end is bridged when the sample after it comes.
class AllanStream {
 public:
  static constexpr std::size_t kExact = 4096;

  /// Refuses a rate_hz that is not finite and positive.
  [[nodiscard]] static base::Result<AllanStream> create(double rate_hz, std::size_t bridge = PhaseRecord::kBridge);
  AllanStream(AllanStream&&) noexcept;
  AllanStream& operator=(AllanStream&&) noexcept;
  ~AllanStream();

  /// The next samples, NaN where one is missing. Refuses infinite ones, naming the index in the record; it has then
  /// taken none of these.
  [[nodiscard]] base::Status push(std::span<const double> rate);

  /// Deviations so far at the averaging times that have at least one difference, rising. May be asked at any time; the
  /// answer changes nothing in what comes later.
  struct Point {
    std::size_t multiple = 0;
    double overlapping = 0.0;
    double modified = 0.0;              ///< NaN where there is none yet
    double overlapping_hadamard = 0.0;  ///< NaN where there is none yet
    std::size_t terms = 0;              ///< of the overlapping Allan deviation
  };
  [[nodiscard]] std::vector<Point> points() const;
  [[nodiscard]] double interval_s() const;
  [[nodiscard]] const MissingSamples& gaps() const;
  /// Phase points of each stretch so far, that of the present one as far as it goes.
  [[nodiscard]] const std::vector<std::size_t>& stretches() const;

 private:
  struct Impl;
  explicit AllanStream(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib::signal
