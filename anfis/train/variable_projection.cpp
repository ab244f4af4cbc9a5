// SPDX-License-Identifier: Apache-2.0
#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "anfis/objective/consequents.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/premises/premise_coordinates.h"
#include "anfis/train/detail/training_steps.h"
#include "anfis/train/learner.h"
#include "base/random.h"

namespace soak::anfis {
namespace {

constexpr double kNoCheck = std::numeric_limits<double>::quiet_NaN();
/// Rounds of new coordinates around a model whose memberships have arrived at their cells' walls.
constexpr int kMostRounds = 8;

/// f(z, gradient): gradient is empty where the optimiser does not ask for it. A value that is not finite ends the
/// minimisation.
using Objective = std::function<double(std::span<const double> z, std::span<double> gradient)>;

struct MinimisationUnderWay {
  nlopt_opt problem;
  const Objective& objective;
};

double call_objective(unsigned count, const double* z, double* gradient, void* data) {
  const auto& under_way = *static_cast<const MinimisationUnderWay*>(data);
  const double value =
      under_way.objective({z, count}, gradient == nullptr ? std::span<double>() : std::span<double>(gradient, count));
  if (!std::isfinite(value)) nlopt_force_stop(under_way.problem);
  return value;
}

nlopt_algorithm algorithm_of(Optimiser optimiser) {
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

/// Moves z from where it is to a local minimum of the objective in a box with NLopt. Stops where the objective is at
/// most `goal`, changes relatively by less than the tolerance, or was evaluated often enough. `not_finite` where it
/// failed.
StopReason minimise(const VariableProjectionOptions& options, const training::PremiseCoordinates& box, double goal,
                    const Objective& objective, std::vector<double>& z) {
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> problem(
      nlopt_create(algorithm_of(options.optimiser), static_cast<unsigned>(z.size())), &nlopt_destroy);
  MinimisationUnderWay under_way{problem.get(), objective};
  nlopt_set_lower_bounds(problem.get(), box.lowest().data());
  nlopt_set_upper_bounds(problem.get(), box.highest().data());
  nlopt_set_min_objective(problem.get(), &call_objective, &under_way);
  nlopt_set_stopval(problem.get(), goal);
  // E is the square of the RMSE.
  nlopt_set_ftol_rel(problem.get(), 2.0 * options.min_rmse_change);
  nlopt_set_maxeval(problem.get(), options.evaluations);
  double least = 0.0;
  switch (nlopt_optimize(problem.get(), z.data(), &least)) {
    case NLOPT_STOPVAL_REACHED:
      return StopReason::goal_reached;
    case NLOPT_MAXEVAL_REACHED:
      return StopReason::epochs_done;
    case NLOPT_SUCCESS:
    case NLOPT_FTOL_REACHED:
    case NLOPT_XTOL_REACHED:
    case NLOPT_ROUNDOFF_LIMITED:
    case NLOPT_FAILURE:  // of the line search: no further progress
      return StopReason::converged;
    default:
      return StopReason::not_finite;
  }
}

/// The descent from one start.
class PremiseSearch {
 public:
  PremiseSearch(const Model& start, const TrainingData& train, const VariableProjectionOptions& options,
                const training::PremiseBounds& bounds, training::CheckingError* checking)
      : options_(options),
        bounds_(bounds),
        checking_(checking),
        problem_(start, train, options.smoothness),
        best_(start, checking != nullptr),
        by_theta_(premise_count(start)) {
    bounds_.apply(problem_.model());
  }

  void run() {
    // The start itself counts: coordinates may move it a little.
    if (!evaluate_model()) {
      reason_ = StopReason::not_finite;
      return;
    }
    if (history_.back().train_rmse <= options_.rmse_goal || by_theta_.empty()) {
      reason_ = by_theta_.empty() ? StopReason::stationary : StopReason::goal_reached;
      return;
    }
    for (int round = 0; round < kMostRounds; ++round) {
      if (!run_round()) return;
    }
  }

  [[nodiscard]] const training::BestModel& best() const { return best_; }
  [[nodiscard]] Training result() && { return std::move(best_).training(reason_, std::move(history_)); }

 private:
  /// One minimisation in coordinates around the present model. True where new coordinates would let it go on.
  bool run_round() {
    const training::PremiseCoordinates coordinates(problem_.model(), bounds_);
    std::vector<double> z = coordinates.of(problem_.model());
    const double goal = options_.rmse_goal * options_.rmse_goal * problem_.error_per_square_rmse();
    reason_ = minimise(
        options_, coordinates, goal,
        [&](std::span<const double> at, std::span<double> gradient) { return error(coordinates, at, gradient); }, z);
    coordinates.set(z, problem_.model());
    if (!history_.empty() && history_.back().train_rmse <= options_.rmse_goal) reason_ = StopReason::goal_reached;
    if (reason_ == StopReason::not_finite && spent()) reason_ = StopReason::epochs_done;
    return reason_ == StopReason::converged && coordinates.touches_neighbour(z);
  }

  double error(const training::PremiseCoordinates& coordinates, std::span<const double> z, std::span<double> gradient) {
    // The optimiser counts a little loosely: a number that is not finite ends it.
    if (spent()) return kNoCheck;
    coordinates.set(z, problem_.model());
    if (!evaluate_model()) return kNoCheck;
    if (!gradient.empty()) {
      problem_.gradient(by_theta_);
      coordinates.chain(z, by_theta_, gradient);
    }
    return problem_.error();
  }

  /// Solves for the consequents and records the errors. False where the problem broke down.
  bool evaluate_model() {
    const double rmse = problem_.solve();
    if (!std::isfinite(rmse)) return false;
    history_.push_back({rmse, checking_ != nullptr ? (*checking_)(problem_.model()) : kNoCheck, kNoCheck});
    best_.offer(problem_.model(), history_.back(), problem_.error(), static_cast<int>(history_.size()));
    return true;
  }

  [[nodiscard]] bool spent() const { return static_cast<int>(history_.size()) >= options_.evaluations; }

  const VariableProjectionOptions& options_;
  const training::PremiseBounds& bounds_;
  training::CheckingError* checking_;
  training::ProjectedProblem problem_;
  training::BestModel best_;
  std::vector<double> by_theta_;
  std::vector<EpochRecord> history_;
  StopReason reason_ = StopReason::epochs_done;
};

/// Draws premises around those of a model: positions by shares of the spacing, widths by factors.
Model drawn_start(const Model& initial, double spread, base::Random& random) {
  Model model = initial;
  for (Input& input : model.inputs) {
    const double range = input.scale.scaled(input.max) - input.scale.scaled(input.min);
    const double spacing = range / static_cast<double>(std::max<std::size_t>(2, input.memberships.size()) - 1);
    for (Membership& membership : input.memberships) {
      const double shift = spread * spacing * random.uniform(-1.0, 1.0);
      const double factor = std::exp(spread * random.gaussian());
      const double c = centre(membership);
      const auto names = parameter_names(membership.shape);
      for (std::size_t p = 0; p < names.size(); ++p) {
        double& value = membership.parameters[p];
        if (names[p] == "slope") continue;
        const bool length = names[p].ends_with("width");
        value = length ? value * factor : c + shift + (value - c) * factor;
      }
    }
  }
  return model;
}

}  // namespace

base::Status VariableProjectionOptions::validate() const {
  if (limits == PremiseLimits::none) {
    return base::bad_input("limits is none: variable projection needs bounds, `resolved` or `ordered`", "limits");
  }
  return training::check_options({{
      {"evaluations", static_cast<double>(evaluations), evaluations >= 1 && evaluations <= 1'000'000, "1..1000000"},
      {"min_rmse_change", min_rmse_change, min_rmse_change >= 0.0 && min_rmse_change < 1.0, "at least 0 and below 1"},
      {"rmse_goal", rmse_goal, rmse_goal >= 0.0 && std::isfinite(rmse_goal), "0 or positive"},
      {"starts", static_cast<double>(starts), starts >= 1 && starts <= 10'000, "1..10000"},
      {"spread", spread, spread > 0.0 && spread <= 1.0, "above 0 and at most 1"},
  }});
}

base::Result<Training> train_variable_projection(const Model& initial, const TrainingData& train,
                                                 const VariableProjectionOptions& options,
                                                 const TrainingData* checking) {
  if (auto status = options.validate(); !status) return base::forward_error(status);
  if (auto status = training::validate_arguments(initial, train, options.smoothness, checking); !status) {
    return base::forward_error(status);
  }
  const training::PremiseBounds bounds(initial, train, options.limits);
  std::optional<training::CheckingError> checking_error;
  if (checking != nullptr) checking_error.emplace(initial, *checking);
  base::Random random(options.seed);
  std::optional<Training> best;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start < options.starts; ++start) {
    const Model from = start == 0 ? initial : drawn_start(initial, options.spread, random);
    PremiseSearch search(from, train, options, bounds, checking_error ? &*checking_error : nullptr);
    search.run();
    if (search.best().empty() || !(search.best().error() < least)) continue;
    least = search.best().error();
    best = std::move(search).result();
    if (best->summary.reason == StopReason::goal_reached) break;
  }
  if (!best) return training::unusable_numbers();
  training::set_level(best->model, train);
  return training::usable(*std::move(best));
}

}  // namespace soak::anfis
