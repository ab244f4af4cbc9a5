// SPDX-License-Identifier: Apache-2.0
#include "anfis/rule_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <string>

namespace soak::anfis {
namespace {

struct Mean {
  double value;
  double standard_error;
};

Mean mean_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double v : values) {
    sum += v;
  }
  const double mean = sum / count;
  double squares = 0.0;
  for (const double v : values) {
    squares += (v - mean) * (v - mean);
  }
  return {mean, std::sqrt(squares / (count - 1.0) / count)};
}

base::Status validate_folds(const TrainingData& data, std::span<const int> fold) {
  if (fold.size() != data.rows()) {
    return base::bad_input("fold has " + std::to_string(fold.size()) + " values for " + std::to_string(data.rows()) +
                               " rows: give one per row",
                           "fold");
  }
  if (std::set<int>(fold.begin(), fold.end()).size() < 2) {
    return base::bad_input("a search needs at least two folds", "fold");
  }
  std::map<int, int> fold_of_group;
  for (std::size_t i = 0; i < data.group.size(); ++i) {
    if (fold_of_group.try_emplace(data.group[i], fold[i]).first->second != fold[i]) {
      return base::bad_input(
          "group " + std::to_string(data.group[i]) + " is split over folds: keep a group in one fold", "fold");
    }
  }
  return {};
}

struct Fold {
  TrainingData train;
  TrainingData held_out;
};

std::vector<Fold> split(const TrainingData& data, std::span<const int> fold) {
  std::vector<Fold> folds;
  for (const int id : std::set<int>(fold.begin(), fold.end())) {
    std::vector<bool> outside(data.rows());
    std::transform(fold.begin(), fold.end(), outside.begin(), [id](int f) { return f != id; });
    std::vector<bool> inside = outside;
    inside.flip();
    folds.push_back({select_rows(data, outside), select_rows(data, inside)});
  }
  return folds;
}

double held_out_error(const Model& model, const TrainingData& held_out) {
  std::vector<double> residuals(held_out.rows());
  evaluate(model, held_out.x, residuals);
  std::transform(held_out.y.begin(), held_out.y.end(), residuals.begin(), residuals.begin(), std::minus<>());
  return shape_rmse(held_out, std::move(residuals));
}

// Held-out error of each fold for one number of rules.
base::Result<std::vector<double>> fold_errors(const std::vector<Fold>& folds, HybridOptions options, int rules) {
  options.rules = rules;
  std::vector<double> errors;
  for (const Fold& fold : folds) {
    const auto training = train_hybrid(fold.train, options);
    if (!training) {
      return base::forward_error(training);
    }
    errors.push_back(held_out_error(training->model, fold.held_out));
  }
  return errors;
}

// A quarter of the resolved inputs stays over to judge the consequents by; two rules need only not interpolate.
int most_rules(const TrainingData& data, int order) {
  const int resolved = resolved_inputs(data);
  const int consequents = order + 1;
  return std::max(3 * resolved / (4 * consequents), std::min(2, (resolved - 1) / consequents));
}

RuleSearch choose(int min_rules, const std::vector<std::vector<double>>& errors) {
  const auto less_mean = [](const auto& a, const auto& b) { return mean_of(a).value < mean_of(b).value; };
  const auto best = std::min_element(errors.begin(), errors.end(), less_mean);
  RuleSearch search;
  search.best = min_rules + static_cast<int>(best - errors.begin());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    std::vector<double> difference(best->size());
    std::transform(errors[i].begin(), errors[i].end(), best->begin(), difference.begin(), std::minus<>());
    const Mean mean = mean_of(errors[i]);
    const Mean excess = mean_of(difference);
    const int rules = min_rules + static_cast<int>(i);
    search.curve.push_back({rules, mean.value, mean.standard_error, excess.value, excess.standard_error});
    if (search.chosen == 0 && excess.value <= excess.standard_error) {
      search.chosen = rules;
    }
  }
  return search;
}

}  // namespace

int resolved_inputs(const TrainingData& data) {
  std::vector<double> sorted = data.x;
  std::sort(sorted.begin(), sorted.end());
  double widest = 0.0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    widest = std::max(widest, sorted[i] - sorted[i - 1]);
  }
  int count = sorted.empty() ? 0 : 1;
  double last = sorted.empty() ? 0.0 : sorted.front();
  for (const double x : sorted) {
    if (x > last && x - last >= 0.5 * widest) {
      ++count;
      last = x;
    }
  }
  return count;
}

base::Result<RuleSearch> search_rules(const TrainingData& data, std::span<const int> fold,
                                      const RuleSearchOptions& options) {
  if (auto status = validate(data, 0); !status) {
    return base::forward_error(status);
  }
  if (auto status = validate_folds(data, fold); !status) {
    return base::forward_error(status);
  }
  const std::vector<Fold> folds = split(data, fold);
  int max_rules = options.max_rules;
  for (const Fold& f : folds) {
    max_rules = std::min(max_rules, most_rules(f.train, options.training.order));
  }
  if (options.min_rules < 2 || max_rules < options.min_rules) {
    return base::bad_input("no number of rules is left to try between " + std::to_string(options.min_rules) + " and " +
                               std::to_string(max_rules) + ": the least is 2, and the most follows from the resolved " +
                               "inputs of the smallest fold",
                           "min_rules, max_rules");
  }
  std::vector<std::vector<double>> errors;
  for (int rules = options.min_rules; rules <= max_rules; ++rules) {
    auto of_rules = fold_errors(folds, options.training, rules);
    if (!of_rules) {
      return base::forward_error(of_rules);
    }
    errors.push_back(std::move(*of_rules));
  }
  return choose(options.min_rules, errors);
}

}  // namespace soak::anfis
