// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "calib/signal/allan/allan.h"

namespace soak::calib::signal::allan {

/// Running sum of rates, sample by sample, with short gaps bridged and long ones ending a stretch. A sink has
///   begin_stretch()  the points that follow are not connected to those before
///   point(x)         the next phase point in units of the sample interval; the first of a stretch is 0
class PhaseIntegrator {
 public:
  explicit PhaseIntegrator(std::size_t bridge) : bridge_(bridge) {}

  template <class Sink>
  void take(double rate, Sink& sink) {
    if (std::isnan(rate)) return miss();
    if (!started_) first_ = rate;
    started_ = true;
    const double value = rate - first_;
    if (!inside_) begin(sink);
    if (gap_ > 0) bridge_to(value, sink);
    add(value, sink);
    last_ = value;
  }

  [[nodiscard]] const MissingSamples& gaps() const { return gaps_; }

 private:
  void miss() {
    ++gaps_.missing;
    if (!inside_ || ++gap_ <= bridge_) return;
    ++gaps_.gaps;
    inside_ = false;
  }

  template <class Sink>
  void begin(Sink& sink) {
    inside_ = true;
    gap_ = 0;
    sum_ = carry_ = 0.0;
    sink.begin_stretch();
    sink.point(0.0);
  }

  template <class Sink>
  void bridge_to(double value, Sink& sink) {
    const double slope = (value - last_) / static_cast<double>(gap_ + 1);
    for (std::size_t k = 1; k <= gap_; ++k) add(last_ + slope * static_cast<double>(k), sink);
    gaps_.bridged += gap_;
    gap_ = 0;
  }

  /// sum + carry is the exact sum but for the rounding of the carry: each point is off by its own last bit only, not by
  /// the accumulated rounding of all before it (Knuth's two-sum).
  template <class Sink>
  void add(double value, Sink& sink) {
    const double sum = sum_ + value;
    const double added = sum - sum_;
    carry_ += (sum_ - (sum - added)) + (value - added);
    sum_ = sum;
    sink.point(sum_ + carry_);
  }

  std::size_t bridge_;
  bool started_ = false;
  bool inside_ = false;  ///< a stretch
  std::size_t gap_ = 0;  ///< missing samples since the last one
  double first_ = 0.0;   ///< rate taken off all
  double last_ = 0.0;
  double sum_ = 0.0;
  double carry_ = 0.0;
  MissingSamples gaps_;
};

/// Differences are added up in blocks of so many beginnings, counted from the first point of the stretch, whatever
/// other multiples are asked for and however the record comes in: that fixes the bits of every sum.
inline constexpr std::size_t kBlock = 4096;

/// Squared differences of one kind at one multiple.
struct SquareSum {
  double sum = 0.0;
  std::size_t terms = 0;
};

/// Largest multiple at which so many phase points without a gap give a difference; 0: none.
[[nodiscard]] std::size_t longest_of(AllanKind kind, std::size_t points);

/// Differences that so many phase points without a gap give at multiple m; 0 for m = 0.
[[nodiscard]] std::size_t terms_of(AllanKind kind, std::size_t points, std::size_t m);

/// Whether add_blocks() takes this multiple: the overlapping kinds, modified Allan only up to kBlock (beyond, windows
/// are longer than blocks).
[[nodiscard]] bool shares_blocks(AllanKind kind, std::size_t m);

/// Adds the differences that begin in the first block of `points`, at each multiple that shares_blocks(); the sums of
/// others stay as they are.
void add_block(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
               std::span<SquareSum> sums);

/// Adds the differences of a stretch, or of its rest from the beginning of a block on, block by block: the multiples
/// share what some blocks have brought into the cache.
void add_blocks(AllanKind kind, std::span<const double> points, std::span<const std::size_t> multiples,
                std::span<SquareSum> sums);

/// Adds the differences of a stretch at one multiple of any kind. Where add_blocks() would do, the same bits.
void add_stretch(AllanKind kind, std::span<const double> points, std::size_t m, SquareSum& sum);

/// The deviation at multiple m [NIST SP 1065 eq. 7-19], from phase in units of the sample interval:
///   Allan sqrt(mean d^2 / 2m^2), Hadamard sqrt(mean d^2 / 6m^2), modified Allan sqrt(mean S^2 / 2m^2 w^2),
/// w the points of the window S (m, or fewer where the points are means over m/w). NaN where there is no term.
[[nodiscard]] double deviation_of(AllanKind kind, const SquareSum& squares, std::size_t m, std::size_t window);

}  // namespace soak::calib::signal::allan
