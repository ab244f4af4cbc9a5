// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>

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

  [[nodiscard]] const GapReport& gaps() const { return gaps_; }

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
  GapReport gaps_;
};

}  // namespace soak::calib::signal::allan
