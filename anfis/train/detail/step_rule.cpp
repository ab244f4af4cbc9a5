// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/detail/step_rule.h"

#include <algorithm>

namespace soak::anfis::training {
namespace {
constexpr int kWait = 4;
constexpr std::array<bool, 4> kFourReductions = {true, true, true, true};
constexpr std::array<bool, 4> kTwoZigzags = {false, true, false, true};
}  // namespace

void StepRule::record(double rmse) {
  std::shift_left(errors_.begin(), errors_.end(), 1);
  errors_.back() = rmse;
  ++epochs_;
  if (decrease_ != 1.0 && epochs_ >= last_decrease_ + kWait && last_four_are(kTwoZigzags)) {
    step_ *= decrease_;
    last_decrease_ = epochs_;
  } else if (increase_ != 1.0 && epochs_ >= last_increase_ + kWait && last_four_are(kFourReductions)) {
    step_ *= increase_;
    last_increase_ = epochs_;
  }
}

bool StepRule::last_four_are(const std::array<bool, 4>& reduction) const {
  for (std::size_t i = 0; i < 4; ++i) {
    const double before = errors_[i];
    const double after = errors_[i + 1];
    if (reduction[i] ? !(after < before) : !(after > before)) return false;
  }
  return true;
}

}  // namespace soak::anfis::training
