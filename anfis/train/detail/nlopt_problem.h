// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "anfis/train/variable_projection.h"

struct nlopt_opt_s;

namespace soak::anfis::training {

/// How a minimisation ended.
enum class MinimisationEnd { converged, goal_reached, evaluations_done, failed };

/// Minimisation of a smooth function in a box with NLopt. The one place that speaks its C interface.
class NloptProblem {
 public:
  /// f(z, gradient): gradient is empty where the optimiser does not ask for it. A value that is not finite ends the
  /// minimisation as failed.
  using Function = std::function<double(std::span<const double> z, std::span<double> gradient)>;

  NloptProblem(Optimiser optimiser, const std::vector<double>& lowest, const std::vector<double>& highest,
               Function function);

  /// Stops where f is at most `goal`, changes relatively by less than `tolerance`, or was evaluated `evaluations`
  /// times.
  void stop_at(double goal, double tolerance, int evaluations);

  /// Moves z from where it is to a local minimum.
  MinimisationEnd minimise(std::vector<double>& z);

 private:
  static double call(unsigned count, const double* z, double* gradient, void* self);

  struct Destroy {
    void operator()(nlopt_opt_s* problem) const;
  };

  Function function_;
  std::unique_ptr<nlopt_opt_s, Destroy> problem_;
};

}  // namespace soak::anfis::training
