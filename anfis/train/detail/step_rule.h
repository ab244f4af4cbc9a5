// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace soak::anfis::training {

/// Length of the premise step from the training errors so far [Jang93; AH05 §6.4.3 corrected]:
///  - four reductions in a row: times `increase`;
///  - two combinations of a rise and a reduction in a row (rise, reduction, rise, reduction): times `decrease`;
///  - after a change, the same kind of change waits for four epochs (a counter for each kind, both starting at the
///    first epoch). A reduction of the step is tested first. A factor of 1 switches its kind off.
class StepRule {
 public:
  StepRule(double initial_step, double decrease, double increase)
      : step_(initial_step), decrease_(decrease), increase_(increase) {}

  [[nodiscard]] double step() const { return step_; }

  /// Takes the training error of the epoch whose step has just been made; the step is that of the next epoch then.
  void record(double rmse);

 private:
  [[nodiscard]] bool last_four_are(const std::array<bool, 4>& reduction) const;

  double step_;
  double decrease_;
  double increase_;
  std::array<double, 5> errors_{};  ///< of the last five epochs
  int epochs_ = 0;
  int last_decrease_ = 1;  ///< epoch, from 1
  int last_increase_ = 1;
};

}  // namespace soak::anfis::training
