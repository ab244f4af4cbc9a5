// SPDX-License-Identifier: Apache-2.0
#include "plain_learner.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace soak::anfis::test {
namespace {

bool is_dropped(const Rule& rule, std::size_t input) {
  return std::find(rule.dropped.begin(), rule.dropped.end(), static_cast<int>(input)) != rule.dropped.end();
}

}  // namespace

PlainLearner::PlainLearner(const Model& initial, const TrainingData& data, const HybridOptions& options)
    : options_(options), model_(initial), inverse_(inverse_covariance(data)) {
  for (std::size_t i = 0; i < data.rows(); ++i) {
    u_.emplace_back();
    for (std::size_t j = 0; j < data.inputs; ++j) {
      const Scale& s = initial.inputs[j].scale;
      u_.back().push_back((Real{data.row(i)[j]} - s.centre) / s.half_range);
    }
    y_.push_back({(Real{data.y[i]} - initial.output.centre) / initial.output.half_range});
    total_weight_ += data.weight.empty() ? 1 : Real{data.weight[i]};
  }
  for (const Input& input : initial.inputs) {
    premises_.emplace_back();
    for (const Membership& m : input.memberships) {
      premises_.back().push_back({m.parameters[0], m.parameters[1], m.parameters[2], m.parameters[3]});
    }
  }
}

std::vector<PlainEpoch> PlainLearner::learn() {
  std::vector<PlainEpoch> history;
  double step = options_.initial_step;
  for (int epoch = 0; epoch < options_.epochs; ++epoch) {
    solve_consequents();
    const Real rmse = model_.output.half_range * std::sqrt(error() / total_weight_);
    history.push_back({static_cast<double>(rmse), step});
    move(step);
    step = next_step(history, step);
  }
  return history;
}

/// [Jang93] Four reductions raise the step; rise, reduction, rise, reduction lower it; each at most every four epochs.
double PlainLearner::next_step(const std::vector<PlainEpoch>& history, double step) {
  const std::size_t epoch = history.size() - 1;
  const auto change = [&](std::size_t back) {
    return epoch < back ? 0.0 : history[epoch - back + 1].rmse - history[epoch - back].rmse;
  };
  if (epoch - last_decrease_ >= 4 && change(1) < 0 && change(2) > 0 && change(3) < 0 && change(4) > 0) {
    last_decrease_ = epoch;
    return step * options_.step_decrease;
  }
  if (epoch - last_increase_ >= 4 && change(1) < 0 && change(2) < 0 && change(3) < 0 && change(4) < 0) {
    last_increase_ = epoch;
    return step * options_.step_increase;
  }
  return step;
}

PlainLearner::Matrix PlainLearner::solve(Matrix a, Matrix b) {  // Gauss-Jordan with pivoting
  const std::size_t n = a.size();
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t p = c;
    for (std::size_t r = c; r < n; ++r) p = std::abs(a[r][c]) > std::abs(a[p][c]) ? r : p;
    std::swap(a[p], a[c]);
    std::swap(b[p], b[c]);
    for (std::size_t r = 0; r < n; ++r) {
      const Real f = r == c ? 0 : a[r][c] / a[c][c];
      for (std::size_t k = c; f != 0 && k < n; ++k) a[r][k] -= f * a[c][k];
      for (std::size_t k = 0; f != 0 && k < b[r].size(); ++k) b[r][k] -= f * b[c][k];
    }
  }
  for (std::size_t r = 0; r < n; ++r) {
    for (Real& value : b[r]) value /= a[r][r];
  }
  return b;
}

PlainLearner::Matrix PlainLearner::inverse_covariance(const TrainingData& data) {
  const std::size_t n = data.rows();
  Matrix v(n, std::vector<Real>(n)), identity(n, std::vector<Real>(n));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n && !data.group.empty(); ++k) {
      v[i][k] = data.group[i] == data.group[k] ? Real{data.group_variance} : 0;
    }
    v[i][i] += data.weight.empty() ? 1 : 1 / Real{data.weight[i]};
    identity[i][i] = 1;
  }
  return solve(std::move(v), std::move(identity));
}

PlainLearner::Real PlainLearner::degree(Shape shape, const Parameters& p, Real u) {
  const auto flank = [](Real t) { return std::exp(-t * t / 2); };
  switch (shape) {
    case Shape::bell:
      return 1 / (1 + std::pow(std::abs((u - p[2]) / p[0]), 2 * p[1]));
    case Shape::gaussian:
      return flank((u - p[1]) / p[0]);
    case Shape::two_sided_gaussian:
      return u < p[1] ? flank((u - p[1]) / p[0]) : u > p[3] ? flank((u - p[3]) / p[2]) : 1;
    case Shape::triangle:
      return std::max(Real{0}, std::min((u - p[0]) / (p[1] - p[0]), (p[2] - u) / (p[2] - p[1])));
    case Shape::trapezoid:
      return std::max(Real{0}, std::min({Real{1}, (u - p[0]) / (p[1] - p[0]), (p[3] - u) / (p[3] - p[2])}));
  }
  throw std::invalid_argument("unknown shape");
}

PlainLearner::Real PlainLearner::strength(const Rule& rule, const std::vector<Real>& u) const {
  Real w = 1;
  for (std::size_t j = 0; j < u.size(); ++j) {
    if (rule.premise[j] == kAny) continue;
    const auto m = static_cast<std::size_t>(rule.premise[j]);
    const Real mu = degree(model_.inputs[j].memberships[m].shape, premises_[j][m], u[j]);
    w = model_.t_norm == TNorm::product ? w * mu : std::min(w, mu);
  }
  return w;
}

std::vector<PlainLearner::Real> PlainLearner::regressors(const std::vector<Real>& u) const {
  std::vector<Real> w;
  Real sum = 0;
  for (const Rule& rule : model_.rules) sum += w.emplace_back(strength(rule, u));
  if (!(sum > 0)) throw std::invalid_argument("no rule fires at some row");
  std::vector<Real> row;
  for (std::size_t i = 0; i < w.size(); ++i) {
    row.push_back(w[i] / sum);
    for (std::size_t j = 0; j < u.size() && model_.order == 1; ++j) {
      if (!is_dropped(model_.rules[i], j)) row.push_back(w[i] / sum * u[j]);
    }
  }
  return row;
}

PlainLearner::Real PlainLearner::error() const {
  std::vector<Real> r;
  for (std::size_t i = 0; i < u_.size(); ++i) {
    const std::vector<Real> row = regressors(u_[i]);
    r.push_back(y_[i][0]);
    for (std::size_t k = 0; k < row.size(); ++k) r.back() -= row[k] * consequents_[k][0];
  }
  Real e = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    for (std::size_t k = 0; k < r.size(); ++k) e += r[i] * inverse_[i][k] * r[k];
  }
  return e;
}

void PlainLearner::solve_consequents() {
  Matrix a;
  for (const auto& u : u_) a.push_back(regressors(u));
  const std::size_t n = a.size(), m = a[0].size();
  Matrix va(n, std::vector<Real>(m)), normal(m, std::vector<Real>(m)), right(m, std::vector<Real>(1));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t c = 0; c < m; ++c) va[i][c] += inverse_[i][k] * a[k][c];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < m; ++c) {
      for (std::size_t d = 0; d < m; ++d) normal[c][d] += a[i][c] * va[i][d];
      right[c][0] += va[i][c] * y_[i][0];
    }
  }
  consequents_ = solve(std::move(normal), std::move(right));
}

void PlainLearner::move(double step) {
  const Real h = 1e-6L;
  std::vector<Real*> parameters;
  std::vector<Real> descent;
  Real square = 0;
  for (std::size_t j = 0; j < premises_.size(); ++j) {
    for (std::size_t m = 0; m < premises_[j].size(); ++m) {
      for (std::size_t k = 0; k < parameter_count(model_.inputs[j].memberships[m].shape); ++k) {
        parameters.push_back(&premises_[j][m][k]);
      }
    }
  }
  for (Real* parameter : parameters) {
    const Real value = *parameter;
    *parameter = value + h;
    const Real above = error();
    *parameter = value - h;
    descent.push_back((error() - above) / (2 * h));
    *parameter = value;
    square += descent.back() * descent.back();
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) *parameters[k] += step * descent[k] / std::sqrt(square);
}

}  // namespace soak::anfis::test
