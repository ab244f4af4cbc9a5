// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/models.h"

#include <algorithm>
#include <cmath>

#include "base/linear/dense_solve.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr double kLeastWeight = 1e-4;

/// Normal equations with columns of unit length.
struct Normal {
  Eigen::VectorXd scale;
  Eigen::MatrixXd gram;
  Eigen::VectorXd moment;
};

Normal normal_equations(const Whitened& problem) {
  Normal normal;
  normal.scale = problem.a.colwise().norm();
  const Eigen::VectorXd inverse = normal.scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd scaled = problem.a * inverse.asDiagonal();
  normal.gram = scaled.transpose() * scaled;
  normal.moment = scaled.transpose() * problem.y;
  return normal;
}

Model solve(const Whitened& problem, const Normal& normal, const std::vector<Eigen::Index>& columns) {
  Model model;
  model.columns = columns;
  const auto p = static_cast<Eigen::Index>(columns.size());
  const Eigen::MatrixXd gram = normal.gram(columns, columns);
  const Eigen::VectorXd moment = normal.moment(columns);
  const Eigen::VectorXd inverse = normal.scale(columns).cwiseInverse();
  const base::Ldlt factor(gram);
  model.estimate = inverse.cwiseProduct(factor.solve(moment));
  const Eigen::MatrixXd gram_inverse = factor.solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(p, p)));
  model.covariance = inverse.asDiagonal() * gram_inverse * inverse.asDiagonal();
  model.chi_squared = (problem.y - problem.a(Eigen::all, columns) * model.estimate).squaredNorm();
  return model;
}

std::vector<Eigen::Index> columns_of(unsigned terms) {
  std::vector<Eigen::Index> columns;
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(kTerms); ++k) {
    if ((terms >> k & 1U) != 0U) columns.push_back(k);
  }
  if (!columns.empty() && columns.back() == markov) columns.push_back(kMarkovTimeColumn);
  return columns;
}

bool is_positive(const Model& model) {
  if (!model.estimate.allFinite() || !model.covariance.allFinite()) return false;
  for (std::size_t j = 0; j < model.columns.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    if (model.covariance(i, i) <= 0.0) return false;
    if (model.columns[j] != kMarkovTimeColumn && model.estimate[i] <= 0.0) return false;
  }
  return true;
}

double cost(const Model& model, double penalty) {
  return model.chi_squared + penalty * static_cast<double>(model.columns.size());
}

/// Sorts, turns costs into shares of belief, drops the negligible.
void weigh(std::vector<Model>& models) {
  std::sort(models.begin(), models.end(),
            [](const Model& a, const Model& b) { return cost(a, kPenalty) < cost(b, kPenalty); });
  const double least = cost(models.front(), kBeliefPenalty);
  for (Model& model : models) model.weight = std::exp(0.5 * (least - cost(model, kBeliefPenalty)));
  std::erase_if(models, [](const Model& model) { return model.weight < kLeastWeight; });
  double sum = 0.0;
  for (const Model& model : models) sum += model.weight;
  for (Model& model : models) model.weight /= sum;
}

}  // namespace

bool Model::has(Eigen::Index column) const {
  return std::find(columns.begin(), columns.end(), column) != columns.end();
}

double Model::value(Eigen::Index column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  return found == columns.end() ? 0.0 : estimate[found - columns.begin()];
}

PerTerm Model::theta() const {
  PerTerm theta{};
  for (std::size_t k = 0; k < kTerms; ++k) theta[k] = value(static_cast<Eigen::Index>(k));
  return theta;
}

Model fit_columns(const Whitened& problem, const std::vector<Eigen::Index>& columns) {
  return solve(problem, normal_equations(problem), columns);
}

std::vector<Model> positive_models(const Whitened& problem) {
  const Normal normal = normal_equations(problem);
  std::vector<Model> models;
  for (unsigned terms = 1; terms < 1U << kTerms; ++terms) {
    const std::vector<Eigen::Index> columns = columns_of(terms);
    if (normal.scale(columns).minCoeff() <= 0.0) continue;
    Model model = solve(problem, normal, columns);
    if (is_positive(model)) models.push_back(std::move(model));
  }
  if (!models.empty()) weigh(models);
  return models;
}

double cost(const Model& model) { return cost(model, kPenalty); }

const Model& closest(const std::vector<Model>& models) {
  return *std::min_element(models.begin(), models.end(),
                           [](const Model& a, const Model& b) { return a.chi_squared < b.chi_squared; });
}

PerTerm mean_theta(const std::vector<Model>& models) {
  PerTerm mean{};
  for (const Model& model : models) {
    const PerTerm theta = model.theta();
    for (std::size_t k = 0; k < kTerms; ++k) mean[k] += model.weight * theta[k];
  }
  return mean;
}

}  // namespace soak::calib::signal::allan_fit
