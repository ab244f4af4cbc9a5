// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/layer.h"

#include <algorithm>

#include "anfis/model/detail/inference.h"
#include "anfis/objective/consequents.h"
#include "anfis/objective/kernels.h"

namespace soak::anfis::training {
namespace {

using Eigen::Index;

Index padded(std::size_t rows) { return static_cast<Index>((rows + kLanes - 1) / kLanes * kLanes); }

Eigen::MatrixXd scaled_inputs(const Model& model, const TrainingData& data) {
  Eigen::MatrixXd u(padded(data.rows()), static_cast<Index>(data.inputs));
  for (Index row = 0; row < u.rows(); ++row) {
    const auto x = data.row(std::min(static_cast<std::size_t>(row), data.rows() - 1));
    for (std::size_t j = 0; j < x.size(); ++j) u(row, static_cast<Index>(j)) = model.inputs[j].scale.scaled(x[j]);
  }
  return u;
}

void degree_column(const Membership& m, const Eigen::MatrixXd& inputs, Index input, double* distance, double* degree) {
  const auto rows = static_cast<std::size_t>(inputs.rows());
  const double* u = inputs.col(input).data();
  const auto& p = m.parameters;
  if (m.shape == Shape::bell) {
    bell_column(rows, u, p[0], p[1], p[2], distance, degree);
  } else if (m.shape == Shape::gaussian) {
    gaussian_column(rows, u, p[0], p[1], distance, degree);
  } else {
    for (std::size_t i = 0; i < rows; ++i) degree[i] = anfis::degree(m, u[i]);
  }
}

}  // namespace

Layer::Layer(const Model& model, const TrainingData& data) : rows_(data.rows()), inputs_(scaled_inputs(model, data)) {
  Index memberships = 0;
  for (const Input& input : model.inputs) {
    first_.push_back(memberships);
    memberships += static_cast<Index>(input.memberships.size());
  }
  const auto rules = static_cast<Index>(model.rules.size());
  distance_.setZero(inputs_.rows(), memberships);
  degree_.setZero(inputs_.rows(), memberships);
  strengths_.setZero(inputs_.rows(), rules);
  pulls_.setZero(inputs_.rows(), rules);
  if (model.t_norm == TNorm::minimum) least_.setZero(inputs_.rows(), rules);
  for (Eigen::VectorXd* column : {&sum_, &output_, &pull_}) column->setZero(inputs_.rows());
  log_strengths_.resize(model.rules.size());
  point_.resize(model.inputs.size());
}

void Layer::compute(const Model& model) {
  compute_degrees(model);
  compute_strengths(model);
}

void Layer::compute_degrees(const Model& model) {
  Index column = 0;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (const Membership& membership : model.inputs[j].memberships) {
      degree_column(membership, inputs_, static_cast<Index>(j), distance_.col(column).data(),
                    degree_.col(column).data());
      ++column;
    }
  }
}

void Layer::multiply_degrees(const Model& model) {
  for (Index i = 0; i < strengths_.cols(); ++i) {
    const std::vector<int>& premise = model.rules[static_cast<std::size_t>(i)].premise;
    auto w = strengths_.col(i);
    bool first = true;
    for (std::size_t j = 0; j < premise.size(); ++j) {
      if (premise[j] == kAny) continue;
      const auto mu = degree_.col(first_[j] + premise[j]);
      if (first) {
        w = mu;
      } else {
        w.array() *= mu.array();
      }
      first = false;
    }
    if (first) w.setOnes();
  }
}

void Layer::take_least_degree(const Model& model) {
  for (Index i = 0; i < strengths_.cols(); ++i) {
    const std::vector<int>& premise = model.rules[static_cast<std::size_t>(i)].premise;
    for (Index row = 0; row < strengths_.rows(); ++row) {
      double least = 2.0;
      int which = kAny;
      for (std::size_t j = 0; j < premise.size(); ++j) {
        if (premise[j] == kAny) continue;
        const double mu = degree_(row, first_[j] + premise[j]);
        if (mu < least) {
          least = mu;
          which = static_cast<int>(j);
        }
      }
      strengths_(row, i) = std::min(least, 1.0);
      least_(row, i) = which;
    }
  }
}

void Layer::compute_strengths(const Model& model) {
  if (model.t_norm == TNorm::product) {
    multiply_degrees(model);
  } else {
    take_least_degree(model);
  }
  sum_ = strengths_.col(0);
  for (Index i = 1; i < strengths_.cols(); ++i) sum_ += strengths_.col(i);
  for (Index row = 0; row < sum_.size(); ++row) {
    if (sum_(row) < inference::kSmallestSum) rescue_row(model, row);
  }
  // [AH05 eq. 5.9]
  sum_.array() = sum_.array().inverse();
  for (Index i = 0; i < strengths_.cols(); ++i) strengths_.col(i).array() *= sum_.array();
}

// The input that decides a rule where degrees have underflowed and only their logarithms differ.
void Layer::find_least_logarithms(const Model& model, Index row) {
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    for (std::size_t j = 0; j < point_.size(); ++j) {
      const int index = model.rules[i].premise[j];
      if (index == kAny) continue;
      const Membership& membership = model.inputs[j].memberships[static_cast<std::size_t>(index)];
      if (log_degree(membership, point_[j]) == log_strengths_[i]) {
        least_(row, static_cast<Index>(i)) = static_cast<int>(j);
        break;
      }
    }
  }
}

void Layer::rescue_row(const Model& model, Index row) {
  for (std::size_t j = 0; j < point_.size(); ++j) point_[j] = inputs_(row, static_cast<Index>(j));
  for (std::size_t i = 0; i < log_strengths_.size(); ++i) {
    log_strengths_[i] = inference::log_strength(model, model.rules[i], point_);
  }
  if (model.t_norm == TNorm::minimum) find_least_logarithms(model, row);
  inference::normalise_logarithms(log_strengths_);
  for (std::size_t i = 0; i < log_strengths_.size(); ++i) strengths_(row, static_cast<Index>(i)) = log_strengths_[i];
  sum_(row) = 1.0;
}

void Layer::consequent_matrix(const Model& model, Eigen::Ref<Eigen::MatrixXd> a) const {
  Index column = 0;
  for_each_consequent(model, [&](std::size_t i, int j) {
    const auto wbar = strengths_.col(static_cast<Index>(i));
    if (j < 0) {
      a.col(column++) = wbar;
    } else {
      a.col(column++) = wbar.cwiseProduct(inputs_.col(j));
    }
  });
}

void Layer::compute_output(const Model& model) {
  const auto rows = static_cast<std::size_t>(inputs_.rows());
  output_.setZero();
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    const auto column = static_cast<Index>(i);
    const Rule& rule = model.rules[i];
    // The consequent f_i, kept until the output is known.
    line(rows, inputs_.col(0).data(), rule.gains[0], rule.offset, pulls_.col(column).data());
    for (std::size_t j = 1; j < rule.gains.size(); ++j) {
      if (rule.gains[j] != 0.0) pulls_.col(column) += rule.gains[j] * inputs_.col(static_cast<Index>(j));
    }
    add_rule_output(rows, strengths_.col(column).data(), pulls_.col(column).data(), output_.data());
  }
  for (Index i = 0; i < pulls_.cols(); ++i) {
    pull_of_rule(rows, strengths_.col(i).data(), output_.data(), pulls_.col(i).data());
  }
}

void Layer::collect_pull(const Model& model, std::size_t input, int membership) {
  pull_.setZero();
  for (std::size_t i = 0; i < model.rules.size(); ++i) {
    if (model.rules[i].premise[input] != membership) continue;
    const auto column = static_cast<Index>(i);
    if (model.t_norm == TNorm::product) {
      pull_ += pulls_.col(column);
      continue;
    }
    // The least degree alone is the strength.
    pull_.array() += (least_.col(column).array() == static_cast<int>(input)).select(pulls_.col(column).array(), 0.0);
  }
}

void Layer::gradient(const Model& model, const Eigen::VectorXd& v, std::span<double> gradient) {
  std::size_t next = 0;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (std::size_t k = 0; k < model.inputs[j].memberships.size(); ++k) {
      const Membership& membership = model.inputs[j].memberships[k];
      const std::size_t count = parameter_count(membership.shape);
      // [AH05 eq. 5.19] v^T df/d theta = sum over rows of v (df/d ln mu) (d ln mu/d theta)
      collect_pull(model, j, static_cast<int>(k));
      pull_.array() *= v.array();
      sum_derivatives(membership, static_cast<Index>(j), first_[j] + static_cast<Index>(k),
                      gradient.subspan(next, count));
      next += count;
    }
  }
}

void Layer::sum_derivatives(const Membership& m, Index input, Index column, std::span<double> sums) const {
  const auto rows = static_cast<std::size_t>(inputs_.rows());
  const double* u = inputs_.col(input).data();
  const double* distance = distance_.col(column).data();
  const auto& p = m.parameters;
  if (m.shape == Shape::bell) {
    std::ranges::copy(bell_gradient(rows, u, distance, degree_.col(column).data(), pull_.data(), p[0], p[1], p[2]),
                      sums.begin());
  } else if (m.shape == Shape::gaussian) {
    std::ranges::copy(gaussian_gradient(rows, u, distance, pull_.data(), p[0], p[1]), sums.begin());
  } else {
    std::ranges::fill(sums, 0.0);
    for (std::size_t row = 0; row < rows_; ++row) {
      const auto d = log_degree_derivatives(m, u[row]);
      for (std::size_t q = 0; q < sums.size(); ++q) sums[q] += pull_(static_cast<Index>(row)) * d[q];
    }
  }
}

Eigen::MatrixXd Layer::jacobian(const Model& model) {
  Eigen::MatrixXd jacobian(static_cast<Index>(rows_), static_cast<Index>(premise_count(model)));
  Index next = 0;
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    for (std::size_t k = 0; k < model.inputs[j].memberships.size(); ++k) {
      const Membership& m = model.inputs[j].memberships[k];
      const auto count = static_cast<Index>(parameter_count(m.shape));
      collect_pull(model, j, static_cast<int>(k));
      for (Index row = 0; row < jacobian.rows(); ++row) {
        const auto d = log_degree_derivatives(m, inputs_(row, static_cast<Index>(j)));
        for (Index q = 0; q < count; ++q) jacobian(row, next + q) = pull_(row) * d[static_cast<std::size_t>(q)];
      }
      next += count;
    }
  }
  return jacobian;
}

}  // namespace soak::anfis::training
