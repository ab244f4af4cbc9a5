// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/structure_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>

#include "anfis/select/uncertainty.h"

namespace soak::anfis {
namespace {

struct Mean {
  double value;
  double standard_error;
};

Mean mean_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / count;
  double squares = 0.0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / (count - 1.0) / count)};
}

std::set<int> fold_ids(std::span<const int> fold) {
  std::set<int> ids(fold.begin(), fold.end());
  ids.erase(kNoJudge);
  return ids;
}

base::Status validate_folds(const TrainingData& data, std::span<const int> fold) {
  if (fold.size() != data.rows()) {
    return base::bad_input("fold has " + std::to_string(fold.size()) + " values for " + std::to_string(data.rows()) +
                               " rows: give one per row",
                           "fold");
  }
  if (!data.precision_factor.empty()) {
    return base::bad_input("condensed rows cannot be split into folds: give all rows", "precision_factor");
  }
  if (fold_ids(fold).size() < 2) {
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
  int id = 0;
  TrainingData train;
  std::vector<TrainingData> held_out;  ///< group by group, or all rows where there are no groups
};

std::vector<TrainingData> split_groups(const TrainingData& data) {
  if (data.group.empty()) return {data};
  std::vector<TrainingData> groups;
  for (const int id : std::set<int>(data.group.begin(), data.group.end())) {
    std::vector<bool> inside(data.rows());
    std::transform(data.group.begin(), data.group.end(), inside.begin(), [id](int g) { return g == id; });
    groups.push_back(select_rows(data, inside));
  }
  return groups;
}

base::Result<std::vector<Fold>> split(const TrainingData& data, std::span<const int> fold, const Condense& condense) {
  std::vector<Fold> folds;
  for (const int id : fold_ids(fold)) {
    std::vector<bool> outside(data.rows());
    std::transform(fold.begin(), fold.end(), outside.begin(), [id](int f) { return f != id; });
    std::vector<bool> inside = outside;
    inside.flip();
    auto train = condense(select_rows(data, outside));
    if (!train) return base::forward_error(train);
    folds.push_back({id, *std::move(train), split_groups(select_rows(data, inside))});
  }
  return folds;
}

double total_weight(const TrainingData& data) {
  return data.weight.empty() ? static_cast<double>(data.rows())
                             : std::accumulate(data.weight.begin(), data.weight.end(), 0.0);
}

base::Result<Training> train_candidate(const TrainingData& data, const StructureSearchOptions& options,
                                       int memberships) {
  RuleBaseOptions rule_base = options.rule_base;
  rule_base.memberships = {memberships};
  const auto initial = grid_rules(data, rule_base);
  if (!initial) return base::forward_error(initial);
  return train(*initial, data, options.learner);
}

/// Held-out errors of one number of memberships.
base::Result<JudgedCandidate> judge(const std::vector<Fold>& folds, const StructureSearchOptions& options,
                                    int memberships) {
  JudgedCandidate candidate{memberships, {}, {}};
  for (const Fold& fold : folds) {
    auto training = train_candidate(fold.train, options, memberships);
    if (!training) return base::forward_error(training);
    for (const TrainingData& rows : fold.held_out) {
      const double rmse = shape_rmse(rows, training->model);
      const double weight = total_weight(rows);
      candidate.errors.push_back({rows.group.empty() ? 0 : rows.group.front(), fold.id, weight, rmse * rmse * weight});
    }
    candidate.models.emplace(fold.id, std::move(training->model));
  }
  return candidate;
}

/// Held-out error of each fold.
std::vector<double> fold_errors(const JudgedCandidate& candidate, std::optional<int> left_out) {
  std::map<int, GroupError> folds;
  for (const GroupError& error : candidate.errors) {
    if (error.group == left_out) continue;
    GroupError& sum = folds[error.fold];
    sum.weight += error.weight;
    sum.squares += error.squares;
  }
  std::vector<double> errors;
  for (const auto& [id, sum] : folds) errors.push_back(std::sqrt(sum.squares / sum.weight));
  return errors;
}

int power(int base, std::size_t exponent) {
  double value = 1.0;
  for (std::size_t i = 0; i < exponent; ++i) value *= base;
  return static_cast<int>(std::min(value, 1e9));
}

double price_of_curvature(const Learner& learner) {
  return std::visit([](const auto& options) { return options.smoothness; }, learner);
}

/// Most memberships per input. A quarter of what the inputs resolve stays over to judge the consequents by, unless a
/// price of curvature holds them; two memberships need only not interpolate.
int most_memberships(const TrainingData& data, const StructureSearchOptions& options) {
  const std::size_t inputs = data.inputs;
  const int consequents = options.rule_base.order == 0 ? 1 : static_cast<int>(inputs) + 1;
  const int resolved = inputs == 1 ? resolved_values(data) : static_cast<int>(distinct_inputs(data));
  const bool priced = price_of_curvature(options.learner) > 0.0;
  int most = 1;
  for (int n = 2; power(n, inputs) <= static_cast<int>(kMostRules); ++n) {
    const int parameters = consequents * power(n, inputs);
    if (n == 2 || priced ? parameters >= resolved : 4 * parameters > 3 * resolved) break;
    most = n;
  }
  return most;
}

StructureSearch choose(int min_memberships, const std::vector<std::vector<double>>& errors) {
  const auto less_mean = [](const auto& a, const auto& b) { return mean_of(a).value < mean_of(b).value; };
  const auto best = std::min_element(errors.begin(), errors.end(), less_mean);
  StructureSearch search;
  search.best = min_memberships + static_cast<int>(best - errors.begin());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    std::vector<double> difference(best->size());
    std::transform(errors[i].begin(), errors[i].end(), best->begin(), difference.begin(), std::minus<>());
    const Mean mean = mean_of(errors[i]);
    const Mean excess = mean_of(difference);
    const int memberships = min_memberships + static_cast<int>(i);
    search.curve.push_back(
        {memberships, memberships, mean.value, mean.standard_error, excess.value, excess.standard_error});
    if (search.chosen == 0 && excess.value <= excess.standard_error) search.chosen = memberships;
  }
  return search;
}

base::Status check_candidates(int most, const StructureSearchOptions& options) {
  if (options.min_memberships >= 2 && most >= options.min_memberships) return {};
  return base::bad_input("no number of memberships can be tried from " + std::to_string(options.min_memberships) +
                             " and " + std::to_string(most) +
                             ": at least 2 are needed, and the distinct inputs of the smallest fold limit the most",
                         "min_memberships, max_memberships");
}

/// Expected squared error of one candidate on all rows; nothing where no rows are left to judge it by.
base::Result<std::optional<double>> error_on_all(const TrainingData& data, const StructureSearchOptions& options,
                                                 int memberships) {
  const auto training = train_candidate(data, options, memberships);
  if (!training) return base::forward_error(training);
  const auto parameters = effective_parameters(training->model, data, price_of_curvature(options.learner));
  if (!parameters) return base::forward_error(parameters);
  const double rows = static_cast<double>(data.measured_rows());
  if (rows - *parameters < 1.0) return std::optional<double>();
  const double rmse = training->summary.train_rmse;
  return expected_squared_error(rmse * rmse * total_weight(data), *parameters);
}

}  // namespace

int resolved_values(const TrainingData& data, std::size_t input) {
  std::vector<double> sorted;
  for (std::size_t i = 0; i < data.rows(); ++i) sorted.push_back(data.row(i)[input]);
  std::sort(sorted.begin(), sorted.end());
  double widest = 0.0;
  for (std::size_t i = 1; i < sorted.size(); ++i) widest = std::max(widest, sorted[i] - sorted[i - 1]);
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

const Model* JudgedCandidate::without(int group) const {
  const auto error = std::ranges::find(errors, group, &GroupError::group);
  return error == errors.end() ? nullptr : &models.at(error->fold);
}

base::Result<std::vector<JudgedCandidate>> judge_structures(const TrainingData& data, std::span<const int> fold,
                                                            const StructureSearchOptions& options,
                                                            const Condense& condense) {
  if (auto status = validate(data, 0); !status) return base::forward_error(status);
  if (auto status = validate_folds(data, fold); !status) return base::forward_error(status);
  const auto folds = split(data, fold, condense);
  if (!folds) return base::forward_error(folds);
  int most = options.max_memberships;
  for (const Fold& f : *folds) most = std::min(most, most_memberships(f.train, options));
  if (auto status = check_candidates(most, options); !status) return base::forward_error(status);
  std::vector<JudgedCandidate> candidates;
  for (int memberships = options.min_memberships; memberships <= most; ++memberships) {
    auto candidate = judge(*folds, options, memberships);
    if (!candidate) return base::forward_error(candidate);
    candidates.push_back(*std::move(candidate));
  }
  return candidates;
}

StructureSearch choose_structure(std::span<const JudgedCandidate> candidates, int most, std::optional<int> left_out) {
  const int fewest = candidates.front().memberships;
  std::vector<std::vector<double>> errors;
  for (const JudgedCandidate& candidate : candidates) {
    if (candidate.memberships <= std::max(most, fewest)) errors.push_back(fold_errors(candidate, left_out));
  }
  return choose(fewest, errors);
}

base::Result<StructureSearch> search_structure(const TrainingData& data, std::span<const int> fold,
                                               const StructureSearchOptions& options) {
  const auto all_rows = [](const TrainingData& rows) { return base::Result<TrainingData>(rows); };
  const auto candidates = judge_structures(data, fold, options, all_rows);
  if (!candidates) return base::forward_error(candidates);
  StructureSearch search = choose_structure(*candidates, options.max_memberships);
  for (StructureSearchPoint& point : search.curve) point.rules = power(point.memberships, data.inputs);
  return search;
}

base::Result<StructureChoice> search_structure(const TrainingData& data, const StructureSearchOptions& options) {
  if (auto status = validate(data, 0); !status) return base::forward_error(status);
  const int most = std::min(options.max_memberships, most_memberships(data, options));
  if (auto status = check_candidates(most, options); !status) return base::forward_error(status);
  StructureChoice choice;
  for (int memberships = options.min_memberships; memberships <= most; ++memberships) {
    const auto error = error_on_all(data, options, memberships);
    if (!error) return base::forward_error(error);
    if (!*error || (choice.memberships > 0 && **error >= choice.expected_error)) continue;
    choice = {memberships, **error};
  }
  if (choice.memberships == 0) {
    return base::bad_input(std::to_string(data.rows()) + " rows leave no candidate anything to be judged by", "x");
  }
  return choice;
}

}  // namespace soak::anfis
