// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/detail/nlopt_problem.h"

#include <nlopt.h>

#include <cmath>

namespace soak::anfis::training {
namespace {

nlopt_algorithm algorithm(Optimiser optimiser) {
  switch (optimiser) {
    case Optimiser::lbfgs:
      return NLOPT_LD_LBFGS;
    case Optimiser::slsqp:
      return NLOPT_LD_SLSQP;
    case Optimiser::sbplx:
      return NLOPT_LN_SBPLX;
  }
  return NLOPT_LD_LBFGS;
}

}  // namespace

void NloptProblem::Destroy::operator()(nlopt_opt_s* problem) const { nlopt_destroy(problem); }

NloptProblem::NloptProblem(Optimiser optimiser, const std::vector<double>& lowest, const std::vector<double>& highest,
                           Function function)
    : function_(std::move(function)),
      problem_(nlopt_create(algorithm(optimiser), static_cast<unsigned>(lowest.size()))) {
  nlopt_set_lower_bounds(problem_.get(), lowest.data());
  nlopt_set_upper_bounds(problem_.get(), highest.data());
  nlopt_set_min_objective(problem_.get(), &NloptProblem::call, this);
}

void NloptProblem::stop_at(double goal, double tolerance, int evaluations) {
  nlopt_set_stopval(problem_.get(), goal);
  nlopt_set_ftol_rel(problem_.get(), tolerance);
  nlopt_set_maxeval(problem_.get(), evaluations);
}

MinimisationEnd NloptProblem::minimise(std::vector<double>& z) {
  double least = 0.0;
  switch (nlopt_optimize(problem_.get(), z.data(), &least)) {
    case NLOPT_STOPVAL_REACHED:
      return MinimisationEnd::goal_reached;
    case NLOPT_MAXEVAL_REACHED:
      return MinimisationEnd::evaluations_done;
    case NLOPT_SUCCESS:
    case NLOPT_FTOL_REACHED:
    case NLOPT_XTOL_REACHED:
    case NLOPT_ROUNDOFF_LIMITED:
    case NLOPT_FAILURE:  // of the line search: no further progress
      return MinimisationEnd::converged;
    default:
      return MinimisationEnd::failed;
  }
}

double NloptProblem::call(unsigned count, const double* z, double* gradient, void* self) {
  auto& problem = *static_cast<NloptProblem*>(self);
  const double value =
      problem.function_({z, count}, gradient == nullptr ? std::span<double>() : std::span<double>(gradient, count));
  if (!std::isfinite(value)) nlopt_force_stop(problem.problem_.get());
  return value;
}

}  // namespace soak::anfis::training
