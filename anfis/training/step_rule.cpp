// SPDX-License-Identifier: Apache-2.0
#include "anfis/training/step_rule.h"

namespace soak::anfis::training {
namespace {
constexpr std::size_t kWait = 4;
constexpr bool kFourReductions[4] = {true, true, true, true};
constexpr bool kTwoZigzags[4] = {false, true, false, true};
}  // namespace

void StepRule::record(double rmse) {
  errors_.push_back(rmse);
  const std::size_t epoch = errors_.size() - 1;
  if (decrease_ != 1.0 && epoch >= last_decrease_ + kWait && last_four_are(kTwoZigzags)) {
    step_ *= decrease_;
    last_decrease_ = epoch;
  } else if (increase_ != 1.0 && epoch >= last_increase_ + kWait && last_four_are(kFourReductions)) {
    step_ *= increase_;
    last_increase_ = epoch;
  }
}

bool StepRule::last_four_are(const bool (&reduction)[4]) const {
  const std::size_t first = errors_.size() - 5;
  for (std::size_t i = 0; i < 4; ++i) {
    const double before = errors_[first + i];
    const double after = errors_[first + i + 1];
    if (reduction[i] ? !(after < before) : !(after > before)) {
      return false;
    }
  }
  return true;
}

}  // namespace soak::anfis::training
