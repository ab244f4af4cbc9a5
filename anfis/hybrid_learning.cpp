// SPDX-License-Identifier: Apache-2.0
#include "anfis/hybrid_learning.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>

#include "anfis/training/step_rule.h"
#include "anfis/training/trainer.h"
#include "base/number_text.h"

namespace soak::anfis {
namespace {

constexpr int kMostRules = 64;
constexpr std::size_t kConvergenceEpochs = 10;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

base::Status out_of_range(const char* option, const std::string& value, const char* range) {
  return base::bad_input(std::string(option) + " is " + value + ": it must be " + range, option);
}

double error_on(const Model& model, const TrainingData* checking) {
  if (checking == nullptr) {
    return kNaN;
  }
  std::vector<double> residuals(checking->rows());
  evaluate(model, checking->x, residuals);
  std::transform(checking->y.begin(), checking->y.end(), residuals.begin(), residuals.begin(), std::minus<>());
  return shape_rmse(*checking, std::move(residuals));
}

bool has_converged(const std::vector<EpochRecord>& history, double min_change) {
  if (min_change == 0.0 || history.size() <= kConvergenceEpochs) {
    return false;
  }
  const auto less = [](const EpochRecord& a, const EpochRecord& b) { return a.train_rmse < b.train_rmse; };
  const auto recent = history.end() - kConvergenceEpochs;
  const double before = std::min_element(history.begin(), recent, less)->train_rmse;
  return std::min_element(recent, history.end(), less)->train_rmse > (1.0 - min_change) * before;
}

// Keeps the best model of a training.
class Best {
 public:
  void offer(const Model& model, const EpochRecord& record, int epoch) {
    const double error = std::isnan(record.check_rmse) ? record.train_rmse : record.check_rmse;
    if (epoch_ == 0 || error < error_) {
      model_ = model;
      record_ = record;
      epoch_ = epoch;
      error_ = error;
    }
  }

  [[nodiscard]] bool empty() const { return epoch_ == 0; }

  [[nodiscard]] Training training(StopReason reason, std::vector<EpochRecord> history) && {
    return {std::move(model_), {reason, epoch_, record_.train_rmse, record_.check_rmse, std::move(history)}};
  }

 private:
  Model model_;
  EpochRecord record_{};
  int epoch_ = 0;
  double error_ = 0.0;
};

// Free offsets leave the level of the curve open: it becomes the mean of the groups' levels.
void set_level(Model& model, const TrainingData& data) {
  struct Sum {
    double weighted = 0.0;
    double weight = 0.0;
  };
  std::map<int, Sum> sums;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const double weight = data.weight.empty() ? 1.0 : data.weight[i];
    Sum& sum = sums[data.group[i]];
    sum.weighted += weight * (data.y[i] - evaluate(model, data.x[i]));
    sum.weight += weight;
  }
  double level = 0.0;
  for (const auto& [group, sum] : sums) {
    level += sum.weighted / sum.weight / static_cast<double>(sums.size());
  }
  for (Rule& rule : model.rules) {
    rule.offset += level / model.output_half_range;
  }
}

base::Status validate_arguments(const TrainingData& train, const HybridOptions& options, const TrainingData* checking) {
  if (auto status = options.validate(); !status) {
    return status;
  }
  const int consequents = options.rules * (options.order + 1);
  if (auto status = validate(train, static_cast<std::size_t>(consequents)); !status) {
    return status;
  }
  if (checking == nullptr) {
    return {};
  }
  auto status = validate(*checking, 0);
  if (!status) {
    status.error().where = "checking data, " + status.error().where;
  }
  return status;
}

}  // namespace

base::Status HybridOptions::validate() const {
  if (rules < 2 || rules > kMostRules) {
    return out_of_range("rules", std::to_string(rules), "2..64");
  }
  if (order != 0 && order != 1) {
    return out_of_range("order", std::to_string(order), "0 or 1");
  }
  if (epochs < 1) {
    return out_of_range("epochs", std::to_string(epochs), "at least 1");
  }
  if (!(initial_step > 0.0 && initial_step <= 1.0)) {
    return out_of_range("initial_step", base::shortest(initial_step), "above 0 and at most 1");
  }
  if (!(step_decrease > 0.0 && step_decrease <= 1.0)) {
    return out_of_range("step_decrease", base::shortest(step_decrease), "above 0 and at most 1");
  }
  if (!(step_increase >= 1.0 && step_increase <= 2.0)) {
    return out_of_range("step_increase", base::shortest(step_increase), "1..2");
  }
  if (!(rmse_goal >= 0.0) || !std::isfinite(rmse_goal)) {
    return out_of_range("rmse_goal", base::shortest(rmse_goal), "0 or positive");
  }
  if (!(min_rmse_change >= 0.0 && min_rmse_change < 1.0)) {
    return out_of_range("min_rmse_change", base::shortest(min_rmse_change), "at least 0 and below 1");
  }
  return {};
}

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
    case StopReason::not_finite:
      return "not finite";
  }
  return "unknown";
}

std::string TrainingSummary::one_line() const {
  std::string line(name(reason));
  line += " after " + std::to_string(history.size()) + " epochs, best " + std::to_string(best_epoch) + ", train RMSE ";
  line += base::shortest(train_rmse);
  if (!std::isnan(check_rmse)) {
    line += ", check RMSE " + base::shortest(check_rmse);
  }
  return line;
}

base::Result<Training> train_hybrid(const TrainingData& train, const HybridOptions& options,
                                    const TrainingData* checking) {
  if (auto status = validate_arguments(train, options, checking); !status) {
    return base::forward_error(status);
  }
  training::Trainer trainer(train, options);
  training::StepRule step_rule(options.initial_step, options.step_decrease, options.step_increase);
  Best best;
  std::vector<EpochRecord> history;
  StopReason reason = StopReason::epochs_done;
  for (int epoch = 1; epoch <= options.epochs; ++epoch) {
    const double rmse = trainer.solve_consequents();
    if (!std::isfinite(rmse)) {
      reason = StopReason::not_finite;
      break;
    }
    history.push_back({rmse, error_on(trainer.model(), checking), step_rule.step()});
    best.offer(trainer.model(), history.back(), epoch);
    if (rmse <= options.rmse_goal) {
      reason = StopReason::goal_reached;
      break;
    }
    if (has_converged(history, options.min_rmse_change)) {
      reason = StopReason::converged;
      break;
    }
    if (epoch < options.epochs && !trainer.move_premises(step_rule.step())) {
      reason = StopReason::stationary;
      break;
    }
    step_rule.record(rmse);
  }
  if (best.empty()) {
    return base::bad_input(
        "the numbers are too large or too small for least squares: change the units of x, y or weight", "first epoch");
  }
  Training training = std::move(best).training(reason, std::move(history));
  if (std::isinf(train.group_variance)) {
    set_level(training.model, train);
  }
  return training;
}

}  // namespace soak::anfis
