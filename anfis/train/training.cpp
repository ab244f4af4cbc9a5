// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/training.h"

#include <cmath>

#include "base/text.h"

namespace soak::anfis {

std::string_view name(StopReason reason) {
  switch (reason) {
    case StopReason::epochs_done:
      return "epochs done";
    case StopReason::goal_reached:
      return "goal reached";
    case StopReason::converged:
      return "converged";
    case StopReason::stationary:
      return "stationary";
    case StopReason::collapsed:
      return "collapsed";
    case StopReason::patience:
      return "patience";
    case StopReason::not_finite:
      return "not finite";
  }
  return "unknown";
}

std::string TrainingSummary::one_line() const {
  std::string line(name(reason));
  line += " after " + std::to_string(history.size()) + " epochs, best " + std::to_string(best_epoch) + ", train RMSE ";
  line += base::shortest(train_rmse);
  if (!std::isnan(check_rmse)) line += ", check RMSE " + base::shortest(check_rmse);
  return line;
}

}  // namespace soak::anfis
