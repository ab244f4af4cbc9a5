// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/learner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "anfis/objective/consequents.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/premises/premise_bounds.h"
#include "anfis/train/detail/training_steps.h"
#include "base/text.h"

namespace soak::anfis {
namespace {

constexpr std::ptrdiff_t kConvergenceEpochs = 10;
constexpr double kUnchecked = std::numeric_limits<double>::quiet_NaN();

/// Least errors up to each epoch.
class LeastErrors {
 public:
  explicit LeastErrors(int epochs) { least_.reserve(static_cast<std::size_t>(epochs)); }

  void add(double rmse) { least_.push_back(least_.empty() ? rmse : std::min(rmse, least_.back())); }

  /// Whether the last ten epochs have lowered the least error by less than this share.
  [[nodiscard]] bool have_settled(double min_change) const {
    if (min_change == 0.0 || std::ssize(least_) <= kConvergenceEpochs) return false;
    return least_.back() > (1.0 - min_change) * *(least_.end() - 1 - kConvergenceEpochs);
  }

 private:
  std::vector<double> least_;
};

/// Without limits a step may carry a width through zero: a bell or Gaussian of negative width is the one of positive
/// width. False where a membership is none any more.
bool keep_shapes(Model& model) {
  bool valid = true;
  training::for_each_membership(model, [&](Membership& membership, std::size_t) {
    auto& p = membership.parameters;
    if (membership.shape == Shape::bell || membership.shape == Shape::gaussian) p[0] = std::abs(p[0]);
    if (membership.shape == Shape::two_sided_gaussian) {
      p[0] = std::abs(p[0]);
      p[2] = std::abs(p[2]);
    }
    valid = valid && validate(membership).has_value();
  });
  return valid;
}

/// Backward pass: moves the premises.
class PremiseStep {
 public:
  PremiseStep(const Model& model, const TrainingData& data, PremiseLimits limits)
      : bounds_(model, data, limits), theta_(premise_count(model)), direction_(theta_.size()) {}

  void admit(Model& model) const { bounds_.apply(model); }

  /// Moves by `step` against the gradient. Where it cannot, says why.
  std::optional<StopReason> move(training::ProjectedProblem& problem, double step) {
    problem.gradient(direction_);
    for (double& d : direction_) d = -d;
    bounds_.block(problem.model(), direction_);
    double norm = 0.0;
    for (const double d : direction_) norm += d * d;
    norm = std::sqrt(norm);
    if (!std::isfinite(norm)) return StopReason::not_finite;
    if (norm == 0.0) return StopReason::stationary;
    training::read_premises(problem.model(), theta_);
    // [AH05 eq. 5.21-5.22] delta theta = -kappa (dE/d theta) / || dE/d theta ||
    for (std::size_t i = 0; i < theta_.size(); ++i) theta_[i] += step * direction_[i] / norm;
    training::set_premises(theta_, problem.model());
    admit(problem.model());
    return keep_shapes(problem.model()) ? std::nullopt : std::make_optional(StopReason::collapsed);
  }

 private:
  training::PremiseBounds bounds_;
  std::vector<double> theta_;
  std::vector<double> direction_;
};

/// One training under way.
class HybridTraining {
 public:
  HybridTraining(const Model& initial, const TrainingData& train, const HybridOptions& options,
                 const TrainingData* checking)
      : options_(options),
        problem_(initial, train, options.smoothness, options.initial_covariance),
        premise_step_(initial, train, options.limits),
        step_rule_(options.initial_step, options.step_decrease, options.step_increase),
        best_(initial, checking != nullptr && !options.keep_by_training_error),
        least_errors_(options.epochs) {
    premise_step_.admit(problem_.model());
    if (checking != nullptr) checking_.emplace(initial, *checking);
    history_.reserve(static_cast<std::size_t>(options.epochs));
  }

  void learn() {
    std::optional<StopReason> reason;
    while (!reason) reason = epoch();
    reason_ = *reason;
  }

  [[nodiscard]] bool found_nothing() const { return best_.empty(); }
  [[nodiscard]] Training result() && { return std::move(best_).training(reason_, std::move(history_)); }

 private:
  std::optional<StopReason> epoch() {
    const double rmse =
        options_.solver == ConsequentSolver::sequential ? problem_.solve_sequentially() : problem_.solve();
    if (!std::isfinite(rmse)) return StopReason::not_finite;
    history_.push_back({rmse, checking_ ? (*checking_)(problem_.model()) : kUnchecked, step_rule_.step()});
    best_.offer(problem_.model(), history_.back(), problem_.error(), static_cast<int>(history_.size()));
    least_errors_.add(rmse);
    if (history_.back().check_rmse < least_check_) {
      least_check_ = history_.back().check_rmse;
      least_check_epoch_ = static_cast<int>(history_.size());
    }
    if (const auto reason = judge(rmse)) return reason;
    if (const auto reason = premise_step_.move(problem_, step_rule_.step())) return reason;
    // With a price of curvature the step follows what descends.
    step_rule_.record(problem_.error());
    return std::nullopt;
  }

  [[nodiscard]] std::optional<StopReason> judge(double rmse) const {
    if (rmse <= options_.rmse_goal) return StopReason::goal_reached;
    if (least_errors_.have_settled(options_.min_rmse_change)) return StopReason::converged;
    const int epochs = static_cast<int>(history_.size());
    if (options_.patience > 0 && epochs - least_check_epoch_ >= options_.patience) return StopReason::patience;
    if (epochs == options_.epochs) return StopReason::epochs_done;
    return std::nullopt;
  }

  HybridOptions options_;
  training::ProjectedProblem problem_;
  PremiseStep premise_step_;
  training::StepRule step_rule_;
  training::BestModel best_;
  LeastErrors least_errors_;
  int least_check_epoch_ = 0;
  double least_check_ = std::numeric_limits<double>::infinity();
  std::optional<training::CheckingError> checking_;
  std::vector<EpochRecord> history_;
  StopReason reason_ = StopReason::epochs_done;
};

}  // namespace

HybridOptions HybridOptions::matlab() {
  HybridOptions options;
  options.epochs = 10;
  options.limits = PremiseLimits::none;
  options.solver = ConsequentSolver::sequential;
  options.keep_by_training_error = true;
  return options;
}

base::Status HybridOptions::validate() const {
  return training::check_options({{
      {"epochs", static_cast<double>(epochs), epochs >= 1 && epochs <= 1'000'000, "1..1000000"},
      {"initial_step", initial_step, initial_step > 0.0 && initial_step <= 1.0, "above 0 and at most 1"},
      {"step_decrease", step_decrease, step_decrease > 0.0 && step_decrease <= 1.0, "above 0 and at most 1"},
      {"step_increase", step_increase, step_increase >= 1.0 && step_increase <= 2.0, "1..2"},
      {"rmse_goal", rmse_goal, rmse_goal >= 0.0 && std::isfinite(rmse_goal), "0 or positive"},
      {"min_rmse_change", min_rmse_change, min_rmse_change >= 0.0 && min_rmse_change < 1.0, "at least 0 and below 1"},
      {"patience", static_cast<double>(patience), patience >= 0, "0 or positive"},
      {"initial_covariance", initial_covariance, initial_covariance > 0.0 && std::isfinite(initial_covariance),
       "positive"},
  }});
}

base::Result<Training> train_hybrid(const Model& initial, const TrainingData& train, const HybridOptions& options,
                                    const TrainingData* checking) {
  if (auto status = options.validate(); !status) return base::forward_error(status);
  if (auto status = training::validate_arguments(initial, train, options.smoothness, checking); !status) {
    return base::forward_error(status);
  }
  if (options.solver == ConsequentSolver::sequential && train.group_variance > 0.0) {
    return base::bad_input("sequential least squares cannot take random offsets: use the least_squares solver",
                           "group_variance");
  }
  if (options.solver == ConsequentSolver::sequential && options.smoothness > 0.0) {
    return base::bad_input("sequential least squares cannot price curvature: use the least_squares solver",
                           "smoothness");
  }
  if (options.patience > 0 && checking == nullptr) {
    return base::bad_input(
        "patience is " + std::to_string(options.patience) + " without checking data: give them, or 0", "patience");
  }
  HybridTraining training_run(initial, train, options, checking);
  training_run.learn();
  if (training_run.found_nothing()) return training::unusable_numbers();
  Training training = std::move(training_run).result();
  training::set_level(training.model, train);
  return training::usable(std::move(training));
}

}  // namespace soak::anfis
