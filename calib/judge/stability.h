// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

namespace soak::calib {

/// When a thermometer counts as settled.
struct StabilityCriterion {
  double slope_kpmin = 0.02;     ///< limit of |slope| plus the half-width of its confidence interval
  double confidence = 0.999;     ///< two-sided, of one look: an experiment looks many times
  double window_s = 300.0;       ///< longest stretch that the slope is taken from
  double min_window_s = 120.0;   ///< shortest
  std::optional<double> step_c;  ///< output step of the thermometer where it is known
};

/// What the readings of one thermometer say.
struct StabilityVerdict {
  bool stable = false;
  bool quantised = false;  ///< steps too coarse for a slope: judge by `standing`, time and another thermometer
  bool standing = false;   ///< has stood still for so long that at the limit it would have taken a step
  std::optional<double> slope_kpmin;       ///< absent while there are too few readings
  std::optional<double> half_width_kpmin;  ///< of the slope's confidence interval
  double window_s = 0.0;                   ///< stretch that was used
};

/// Judges from a thermometer's readings whether its temperature still moves.
///
/// The slope is that of a straight line through the means of `kBlocks` blocks of equal length; its standard error comes
/// from the residuals of these means, so that noise which is correlated over less than a block is counted as it is. A
/// temperature that still approaches its end is steeper at the start of the window than now: the verdict errs towards
/// "not yet".
///
/// A thermometer is `quantised`, and never stable by itself, if at the limit it would move by less than two of its
/// steps within the window while its noise does not reach three of them: a whole-degree display stands still while the
/// truth moves. What can be said of it: readings that did not change for the time that the limit takes for one step
/// (twice that where they flicker between two neighbours) are `standing`; a temperature that approaches its end is then
/// slower than the limit. Without `step_c` the step is the smallest difference that the readings show; readings that
/// are all equal show none, and count as quantised.
class StabilityJudge {
 public:
  static constexpr int kBlocks = 12;

  explicit StabilityJudge(const StabilityCriterion& criterion);

  /// A reading at device time `t_s`, which does not fall. Readings less than 0.2 s after the last one are passed over.
  void add(double t_s, double temp_c);
  /// The set point changed, the fixture turned, a door opened, time began anew: what was read before does not count.
  /// `min_window_s` is the shortest stretch from now on.
  /// A turn (with `min_window_s`) does not end a standstill, anything else does.
  void disturb(double min_window_s);
  void disturb() {
    disturb(criterion_.min_window_s);
    still_.reset();
  }

  /// Cost linear in the readings of a window.
  [[nodiscard]] StabilityVerdict verdict() const;

 private:
  struct Reading {
    double t_s = 0.0;
    double temp_c = 0.0;
  };

  /// Readings that stay within one step.
  struct Standstill {
    double since_s = 0.0;
    double low_c = 0.0;
    double high_c = 0.0;
  };

  void follow_standstill(double t_s, double temp_c);
  [[nodiscard]] bool is_standing() const;
  [[nodiscard]] bool is_quantised(double window_s) const;
  /// Root mean square of the readings about their straight line.
  [[nodiscard]] double scatter_c() const;

  StabilityCriterion criterion_;
  double min_window_s_;
  std::deque<Reading> readings_;
  std::optional<Standstill> still_;
};

}  // namespace soak::calib
