// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/cluster_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "anfis/model/rule_base.h"
#include "anfis/objective/level.h"
#include "anfis/objective/projected_problem.h"

namespace soak::anfis::fuzzy {
namespace {

// Inputs that are no antecedents lose their memberships.
void ask_only_about(const std::vector<int>& antecedents, Model& model) {
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    if (std::ranges::binary_search(antecedents, static_cast<int>(j))) {
      continue;
    }
    model.inputs[j].memberships.clear();
    for (Rule& rule : model.rules) {
      rule.premise[j] = kAny;
    }
  }
}

}  // namespace

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

void solve_consequents(const TrainingData& data, Model& model) {
  training::ProjectedProblem problem(model, data);
  problem.solve();
  model = problem.model();
  training::set_level(model, data);
}

}  // namespace soak::anfis::fuzzy
