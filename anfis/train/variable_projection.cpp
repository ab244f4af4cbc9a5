// SPDX-License-Identifier: Apache-2.0
#include "anfis/train/variable_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "anfis/objective/level.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/premises/premise_bounds.h"
#include "anfis/premises/premise_coordinates.h"
#include "anfis/train/detail/best_model.h"
#include "anfis/train/detail/nlopt_problem.h"
#include "anfis/train/detail/training_arguments.h"
#include "base/random.h"
#include "base/text.h"

namespace soak::anfis {
namespace {

using training::MinimisationEnd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Rounds of new coordinates around a model whose memberships have arrived at their cells' walls.
constexpr int kMostRounds = 8;

base::Status out_of_range(const char* option, const std::string& value, const char* range) {
  return base::bad_input(std::string(option) + " is " + value + ": it must be " + range, option);
}

/// The descent from one start.
class Descent {
 public:
  Descent(const Model& start, const TrainingData& train, const VariableProjectionOptions& options,
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
    training::NloptProblem minimisation(
        options_.optimiser, coordinates.lowest(), coordinates.highest(),
        [&](std::span<const double> at, std::span<double> gradient) { return error(coordinates, at, gradient); });
    const double goal = options_.rmse_goal * options_.rmse_goal * problem_.error_per_square_rmse();
    // E is the square of the RMSE.
    minimisation.stop_at(goal, 2.0 * options_.min_rmse_change, options_.evaluations);
    const MinimisationEnd end = minimisation.minimise(z);
    coordinates.set(z, problem_.model());
    reason_ = reason(end);
    return reason_ == StopReason::converged && coordinates.touches_neighbour(z);
  }

  double error(const training::PremiseCoordinates& coordinates, std::span<const double> z, std::span<double> gradient) {
    // The optimiser counts a little loosely: a number that is not finite ends it.
    if (spent()) return kNaN;
    coordinates.set(z, problem_.model());
    if (!evaluate_model()) return kNaN;
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
    history_.push_back({rmse, checking_ != nullptr ? (*checking_)(problem_.model()) : kNaN, kNaN});
    best_.offer(problem_.model(), history_.back(), problem_.error(), static_cast<int>(history_.size()));
    return true;
  }

  [[nodiscard]] bool spent() const { return static_cast<int>(history_.size()) >= options_.evaluations; }

  [[nodiscard]] StopReason reason(MinimisationEnd end) const {
    if (!history_.empty() && history_.back().train_rmse <= options_.rmse_goal) return StopReason::goal_reached;
    switch (end) {
      case MinimisationEnd::converged:
        return StopReason::converged;
      case MinimisationEnd::goal_reached:
        return StopReason::goal_reached;
      case MinimisationEnd::evaluations_done:
        return StopReason::epochs_done;
      case MinimisationEnd::failed:
        break;
    }
    return spent() ? StopReason::epochs_done : StopReason::not_finite;
  }

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
  if (evaluations < 1 || evaluations > 1'000'000) {
    return out_of_range("evaluations", std::to_string(evaluations), "1..1000000");
  }
  if (!(min_rmse_change >= 0.0 && min_rmse_change < 1.0)) {
    return out_of_range("min_rmse_change", base::shortest(min_rmse_change), "at least 0 and below 1");
  }
  if (!(rmse_goal >= 0.0) || !std::isfinite(rmse_goal)) {
    return out_of_range("rmse_goal", base::shortest(rmse_goal), "0 or positive");
  }
  if (limits == PremiseLimits::none) {
    return base::bad_input("limits is none: variable projection needs bounds, `resolved` or `ordered`", "limits");
  }
  if (starts < 1 || starts > 10'000) return out_of_range("starts", std::to_string(starts), "1..10000");
  if (!(spread > 0.0 && spread <= 1.0)) return out_of_range("spread", base::shortest(spread), "above 0 and at most 1");
  return {};
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
    Descent descent(from, train, options, bounds, checking_error ? &*checking_error : nullptr);
    descent.run();
    if (descent.best().empty() || !(descent.best().error() < least)) continue;
    least = descent.best().error();
    best = std::move(descent).result();
    if (best->summary.reason == StopReason::goal_reached) break;
  }
  if (!best) return training::unusable_numbers();
  training::set_level(best->model, train);
  return training::usable(*std::move(best));
}

}  // namespace soak::anfis
