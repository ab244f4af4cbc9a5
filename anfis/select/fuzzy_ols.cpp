// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/fuzzy_ols.h"

#include <fmt/format.h>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <tuple>
#include <utility>

#include "anfis/model/rule_base.h"
#include "anfis/objective/consequents.h"
#include "anfis/objective/projected_problem.h"
#include "anfis/select/detail/compaction.h"
#include "anfis/train/detail/training_steps.h"

namespace soak::anfis {
namespace {

// Consequent thresholds that are tried, as shares of the option, the boldest first.
constexpr std::array<double, 4> kThresholdShares = {1.0, 0.25, 0.0625, 0.0};

// Most consequents per distinct row: fewer rows leave nothing to average noise over.
constexpr double kConsequentsPerRow = 0.75;

// Inputs that are no antecedents lose their memberships.
void ask_only_about(const std::vector<int>& antecedents, Model& model) {
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    if (std::ranges::binary_search(antecedents, static_cast<int>(j))) continue;
    model.inputs[j].memberships.clear();
    for (Rule& rule : model.rules) rule.premise[j] = kAny;
  }
}

/// One rule per cluster, in their order: a Gaussian membership per antecedent with the cluster's centre and standard
/// deviation, kAny for the other inputs, which have no memberships. Consequents are 0. Refuses what scatter_rules()
/// refuses: numbers that differ too much in size.
base::Result<Model> cluster_model(const TrainingData& data, const Clustering& clustering,
                                  const std::vector<int>& antecedents) {
  const auto rules = static_cast<Eigen::Index>(clustering.clusters.size());
  Eigen::MatrixXd centres(rules, static_cast<Eigen::Index>(data.inputs));
  Eigen::MatrixXd widths(centres.rows(), centres.cols());
  for (Eigen::Index i = 0; i < rules; ++i) {
    const Cluster& cluster = clustering.clusters[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < centres.cols(); ++j) {
      const Scale& scale = clustering.inputs[static_cast<std::size_t>(j)];
      centres(i, j) = scale.unscaled(cluster.centre(j));
      widths(i, j) = scale.half_range * std::sqrt(cluster.variance(j));
    }
  }
  RuleBaseOptions options;
  options.shape = Shape::gaussian;
  auto model = scatter_rules(data, centres, widths, options);
  if (model) ask_only_about(antecedents, *model);
  return model;
}

/// Gives all rules the consequents that together fit the data best, by whitened least squares over the firing strengths
/// [AH05 eq. 5.12-5.13]; dropped gains stay 0.
void solve_consequents(const TrainingData& data, Model& model) {
  training::ProjectedProblem problem(model, data);
  problem.solve();
  model = problem.model();
  training::set_level(model, data);
}

// A structure, its clusters, and what the rows held out say about it.
struct Judged {
  Clustering clustering;
  FuzzyOlsStage stage;
  Eigen::VectorXd errors;
};

// One number of clusters: its report, and a structure per stage of the elimination.
struct Explored {
  FuzzyOlsCandidate report;
  std::vector<Judged> path;

  [[nodiscard]] const Judged& chosen() const { return path[report.chosen]; }
};

std::vector<int> all_inputs(std::size_t inputs) {
  std::vector<int> all(inputs);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Judged judge(const fuzzy::Split& rows, Clustering clustering, Model model, const std::vector<int>& antecedents) {
  solve_consequents(rows.fit, model);
  FuzzyOlsStage stage{static_cast<int>(model.rules.size()), antecedents, static_cast<int>(consequent_count(model)),
                      shape_rmse(rows.fit, model), shape_rmse(rows.held_out, model)};
  return {std::move(clustering), std::move(stage), fuzzy::unit_errors(rows.held_out, model)};
}

// Backward elimination of antecedents [AH05 §5.4.2 II].
base::Result<Explored> explore(const fuzzy::Split& rows, ClusteringOptions options, int clusters) {
  Explored explored;
  FuzzyOlsCandidate& report = explored.report;
  report.clusters = options.clusters = clusters;
  std::vector<int> antecedents = all_inputs(rows.fit.inputs);
  options.antecedents = antecedents;
  Clustering clustering = cluster_takagi_sugeno(rows.fit, options).value();  // data and options were checked
  for (;;) {
    const fuzzy::ClassCovariances covariances = fuzzy::class_covariances(clustering.clusters);
    auto model = cluster_model(rows.fit, clustering, antecedents);
    if (!model) return base::forward_error(model);
    explored.path.push_back(judge(rows, clustering, *std::move(model), antecedents));
    report.elimination.push_back(explored.path.back().stage);
    report.log_separability.push_back(fuzzy::log_separability(covariances, antecedents));
    report.ranking.push_back(fuzzy::least_needed(covariances, antecedents));
    if (antecedents.size() == 1) break;
    options.antecedents = antecedents = fuzzy::without(antecedents, report.ranking.back());
    clustering = refine_clusters(rows.fit, clustering, options).value();
  }
  std::vector<Eigen::VectorXd> errors;  // simplest first
  for (auto step = explored.path.rbegin(); step != explored.path.rend(); ++step) errors.push_back(step->errors);
  report.chosen = explored.path.size() - 1 - fuzzy::simplest_as_good(errors);
  return explored;
}

// Ranks the consequent terms of each rule by its cluster's memberships and drops the last ones from the model.
std::vector<ConsequentRanking> compact_consequents(const TrainingData& data, const Clustering& clustering,
                                                   double threshold, Model& model) {
  const fuzzy::ScaledRows rows = fuzzy::scaled_rows(data, {clustering.inputs, clustering.output});
  std::vector<ConsequentRanking> rankings;
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    const fuzzy::ErrorReduction reduction =
        fuzzy::error_reduction(rows, clustering.memberships.col(static_cast<Eigen::Index>(i)));
    const std::size_t kept = fuzzy::terms_kept(reduction, threshold);
    model.rules[i].dropped.assign(reduction.order.begin() + static_cast<std::ptrdiff_t>(kept), reduction.order.end());
    std::ranges::sort(model.rules[i].dropped);
    rankings.push_back({reduction.offset, reduction.order, reduction.ratios, kept});
  }
  return rankings;
}

// The boldest threshold that is as good as the best, and the stage that it leads to.
base::Result<std::pair<double, FuzzyOlsStage>> choose_threshold(const fuzzy::Split& rows, const Judged& chosen,
                                                                double boldest) {
  std::vector<FuzzyOlsStage> stages;
  std::vector<Eigen::VectorXd> errors;
  for (const double share : kThresholdShares) {
    auto model = cluster_model(rows.fit, chosen.clustering, chosen.stage.antecedents);
    if (!model) return base::forward_error(model);
    compact_consequents(rows.fit, chosen.clustering, share * boldest, *model);
    Judged judged = judge(rows, chosen.clustering, *std::move(model), chosen.stage.antecedents);
    stages.push_back(std::move(judged.stage));
    errors.push_back(std::move(judged.errors));
  }
  const std::size_t choice = fuzzy::simplest_as_good(errors);
  return std::pair(kThresholdShares[choice] * boldest, stages[choice]);
}

// The model of the chosen structure on all rows.
base::Result<FuzzyOls> final_model(const TrainingData& data, const Judged& chosen, ClusteringOptions options,
                                   FuzzyOlsReport report) {
  options.antecedents = chosen.stage.antecedents;
  const Clustering clustering = refine_clusters(data, chosen.clustering, options).value();
  auto model = cluster_model(data, clustering, options.antecedents);
  if (!model) return base::forward_error(model);
  FuzzyOls result{*std::move(model), std::move(report)};
  result.report.consequents = compact_consequents(data, clustering, result.report.threshold, result.model);
  solve_consequents(data, result.model);
  result.report.clustering = clustering.summary;
  result.report.train_rmse = shape_rmse(data, result.model);
  return result;
}

int most_clusters(const TrainingData& fit) {
  return static_cast<int>(kConsequentsPerRow * static_cast<double>(distinct_inputs(fit)) /
                          static_cast<double>(fit.inputs + 1));
}

// Whether the rows fitted can carry the least number of clusters.
base::Status check_rows(const TrainingData& fit, int least_clusters) {
  if (auto status = validate(fit, 0); !status) {
    return base::bad_input(status.error().message + " (without the rows held out)", status.error().where);
  }
  if (most_clusters(fit) >= least_clusters) {
    return {};
  }
  return base::bad_input(
      fmt::format(
          "{} distinct rows, without those held out, are too few for {} clusters of {} inputs: give at least {}",
          distinct_inputs(fit), least_clusters, fit.inputs,
          std::ceil(least_clusters * static_cast<double>(fit.inputs + 1) / kConsequentsPerRow)),
      "x");
}

// All numbers of clusters that the rows can carry, and which to take.
base::Result<std::vector<Explored>> explore_all(const fuzzy::Split& rows, const FuzzyOlsOptions& options,
                                                FuzzyOlsReport& report) {
  std::vector<Explored> explored;
  std::vector<Eigen::VectorXd> errors;
  for (const int clusters : options.clusters) {
    if (clusters > most_clusters(rows.fit)) break;
    auto one = explore(rows, options.clustering, clusters);
    if (!one) return base::forward_error(one);
    explored.push_back(*std::move(one));
    errors.push_back(explored.back().chosen().errors);
    report.candidates.push_back(explored.back().report);
  }
  report.chosen = fuzzy::simplest_as_good(errors);
  return explored;
}

}  // namespace

base::Status FuzzyOlsOptions::validate() const {
  const bool rising = std::ranges::adjacent_find(clusters, std::greater_equal<>()) == clusters.end();
  if (clusters.empty() || !rising || clusters.front() < 1 || clusters.back() > static_cast<int>(kMostMemberships)) {
    return base::bad_input(fmt::format("clusters is {}: it must be rising numbers, 1..256", fmt::join(clusters, ", ")),
                           "clusters");
  }
  if (auto status = training::check_options({{
          {"held_out_share", held_out_share, held_out_share > 0.0 && held_out_share <= 0.5, "above 0, at most 0.5"},
          {"consequent_threshold", consequent_threshold, consequent_threshold >= 0.0 && consequent_threshold < 1.0,
           "at least 0, below 1"},
      }});
      !status) {
    return status;
  }
  return clustering.validate();
}

std::string FuzzyOlsReport::one_line() const {
  return fmt::format("{} rules, antecedents {}, {} of {} consequents: held-out RMSE {:.6g}, {:.6g} before compaction",
                     compact.rules, fmt::join(compact.antecedents, " "), compact.consequents, full.consequents,
                     compact.held_out_rmse, full.held_out_rmse);
}

base::Result<FuzzyOls> fuzzy_ols(const TrainingData& data, const FuzzyOlsOptions& options) {
  if (auto status = options.validate(); !status) return base::forward_error(status);
  if (auto status = validate(data, 2); !status) return base::forward_error(status);
  if (!data.precision_factor.empty()) {
    return base::bad_input("condensed rows cannot be clustered: give all rows", "precision_factor");
  }
  if (!std::isfinite(shape_rmse(data, data.y))) return training::unusable_numbers();
  const fuzzy::Split rows = fuzzy::split(data, options.held_out_share, options.clustering.seed);
  if (auto status = check_rows(rows.fit, options.clusters.front()); !status) return base::forward_error(status);
  FuzzyOlsReport report;
  const auto explored = explore_all(rows, options, report);
  if (!explored) return base::forward_error(explored);
  const Explored& best = (*explored)[report.chosen];
  const Judged& chosen = best.chosen();
  report.full = best.path.front().stage;
  report.compact_antecedents = chosen.stage;
  auto threshold = choose_threshold(rows, chosen, options.consequent_threshold);
  if (!threshold) return base::forward_error(threshold);
  std::tie(report.threshold, report.compact) = *std::move(threshold);
  auto result = final_model(data, chosen, options.clustering, std::move(report));
  if (!result) return base::forward_error(result);
  if (!validate(result->model) || !std::isfinite(result->report.train_rmse)) return training::unusable_numbers();
  return result;
}

}  // namespace soak::anfis
