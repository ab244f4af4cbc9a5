// SPDX-License-Identifier: Apache-2.0
#include "anfis/training_data.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "anfis/group_whitening.h"

namespace soak::anfis {
namespace {

std::string row_name(std::size_t row) { return "row " + std::to_string(row); }

base::Status validate_sizes(const TrainingData& data) {
  const auto check = [&](std::size_t size, const char* column) -> base::Status {
    if (size == data.rows()) {
      return {};
    }
    return base::bad_input(std::string(column) + " has " + std::to_string(size) + " values for " +
                               std::to_string(data.rows()) + " of x: give one per row",
                           column);
  };
  if (auto status = check(data.y.size(), "y"); !status) {
    return status;
  }
  if (auto status = data.weight.empty() ? base::Status{} : check(data.weight.size(), "weight"); !status) {
    return status;
  }
  return data.group.empty() ? base::Status{} : check(data.group.size(), "group");
}

base::Status validate_values(const TrainingData& data) {
  for (std::size_t i = 0; i < data.rows(); ++i) {
    if (!std::isfinite(data.x[i]) || !std::isfinite(data.y[i])) {
      return base::bad_input("x and y must be finite numbers: leave the row out", row_name(i));
    }
    if (!data.weight.empty() && (!std::isfinite(data.weight[i]) || data.weight[i] <= 0.0)) {
      return base::bad_input("the weight must be positive and finite: leave out rows that shall not count",
                             row_name(i));
    }
  }
  if (!(data.group_variance >= 0.0)) {
    return base::bad_input("the variance of the groups' offsets must not be negative", "group_variance");
  }
  if (data.group_variance > 0.0 && data.group.empty()) {
    return base::bad_input("a variance of the groups' offsets needs the group of each row", "group");
  }
  return {};
}

}  // namespace

std::size_t distinct_inputs(const TrainingData& data) {
  std::vector<double> sorted = data.x;
  std::sort(sorted.begin(), sorted.end());
  return static_cast<std::size_t>(std::unique(sorted.begin(), sorted.end()) - sorted.begin());
}

base::Status validate(const TrainingData& data, std::size_t parameters) {
  if (auto status = validate_sizes(data); !status) {
    return status;
  }
  if (data.rows() == 0) {
    return base::bad_input("there are no rows to learn from", "x");
  }
  if (auto status = validate_values(data); !status) {
    return status;
  }
  const std::size_t distinct = distinct_inputs(data);
  if (distinct < 2) {
    return base::bad_input("x is constant: a curve needs at least two different inputs", "x");
  }
  if (distinct < parameters) {
    return base::bad_input("x has " + std::to_string(distinct) + " distinct values for " + std::to_string(parameters) +
                               " consequent parameters: use fewer rules, order 0, or more data",
                           "x");
  }
  return {};
}

TrainingData select_rows(const TrainingData& data, const std::vector<bool>& keep) {
  TrainingData selected;
  selected.group_variance = data.group_variance;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    if (!keep[i]) {
      continue;
    }
    selected.x.push_back(data.x[i]);
    selected.y.push_back(data.y[i]);
    if (!data.weight.empty()) {
      selected.weight.push_back(data.weight[i]);
    }
    if (!data.group.empty()) {
      selected.group.push_back(data.group[i]);
    }
  }
  return selected;
}

double shape_rmse(const TrainingData& data, std::vector<double> residuals) {
  const double variance = data.group_variance > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
  const GroupWhitening whitening(data.rows(), data.weight, data.group, variance);
  Eigen::Map<Eigen::VectorXd> r(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  whitening.apply(r);
  return std::sqrt(r.squaredNorm() / whitening.total_weight());
}

}  // namespace soak::anfis
