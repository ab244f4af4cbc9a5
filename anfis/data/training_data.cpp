// SPDX-License-Identifier: Apache-2.0
#include "anfis/data/training_data.h"

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "anfis/linear/least_squares.h"

namespace soak::anfis {
namespace {

bool is_usable(double value) { return std::abs(value) <= kLargestNumber; }

std::string row_name(std::size_t row) { return "row " + std::to_string(row); }

base::Status validate_sizes(const TrainingData& data) {
  const auto check = [&](std::size_t size, const char* column) -> base::Status {
    if (size == data.rows()) {
      return {};
    }
    return base::bad_input(std::string(column) + " has " + std::to_string(size) + " values for " +
                               std::to_string(data.rows()) + " rows of x: give one per row",
                           column);
  };
  if (data.inputs == 0 || data.x.size() % data.inputs != 0) {
    return base::bad_input(std::to_string(data.x.size()) + " values of x cannot be split into rows of " +
                               std::to_string(data.inputs) + " inputs",
                           "x");
  }
  if (auto status = check(data.y.size(), "y"); !status) return status;
  if (auto status = data.weight.empty() ? base::Status{} : check(data.weight.size(), "weight"); !status) return status;
  if (auto status = data.group.empty() ? base::Status{} : check(data.group.size(), "group"); !status) return status;
  const std::size_t factor = data.precision_factor.size();
  if (factor == 0 || (factor == data.rows() * data.rows() && data.group.empty())) return {};
  return base::bad_input("condensed rows have a factor of rows x rows numbers and no groups: take them from condense()",
                         "precision_factor");
}

base::Status validate_values(const TrainingData& data) {
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const auto x = data.row(i);
    if (!is_usable(data.y[i]) || !std::all_of(x.begin(), x.end(), is_usable)) {
      return base::bad_input("x and y must be finite numbers of at most 1e100: leave the row out or change the units",
                             row_name(i));
    }
    if (!data.weight.empty() && !(data.weight[i] >= 1.0 / kLargestNumber && data.weight[i] <= kLargestNumber)) {
      return base::bad_input(
          "the weight must be from 1e-100 to 1e100: remove rows that should not count, or change the units",
          row_name(i));
    }
  }
  if (!(data.group_variance >= 0.0)) {
    return base::bad_input("the variance of the groups' offsets must not be negative", "group_variance");
  }
  if (!std::ranges::all_of(data.precision_factor, is_usable) || !is_usable(data.squares_within)) {
    return base::bad_input("the factor of condensed rows must be finite numbers: change the units of the weights",
                           "precision_factor");
  }
  if (data.group_variance > 0.0 && data.group.empty()) {
    return base::bad_input("a variance of the groups' offsets needs the group of each row", "group");
  }
  return {};
}

bool is_constant(const TrainingData& data, std::size_t input) {
  for (std::size_t i = 1; i < data.rows(); ++i)
    if (data.row(i)[input] != data.row(0)[input]) return false;
  return true;
}

/// Whether there are `count` distinct inputs, usually known after a few rows: a learner asks before every training.
bool has_distinct_inputs(const TrainingData& data, std::size_t count) {
  std::vector<std::size_t> first;  // row of each distinct input so far
  for (std::size_t i = 0; i < data.rows() && first.size() < count; ++i) {
    const auto same = [&](std::size_t seen) { return std::ranges::equal(data.row(seen), data.row(i)); };
    if (std::ranges::none_of(first, same)) first.push_back(i);
  }
  return first.size() >= count;
}

}  // namespace

std::size_t distinct_inputs(const TrainingData& data) {
  std::vector<std::size_t> order(data.rows());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto less = [&](std::size_t a, std::size_t b) {
    return std::ranges::lexicographical_compare(data.row(a), data.row(b));
  };
  std::sort(order.begin(), order.end(), less);
  const auto same = [&](std::size_t a, std::size_t b) { return std::ranges::equal(data.row(a), data.row(b)); };
  return static_cast<std::size_t>(std::unique(order.begin(), order.end(), same) - order.begin());
}

base::Status validate(const TrainingData& data, std::size_t parameters) {
  if (auto status = validate_sizes(data); !status) return status;
  if (data.rows() == 0) return base::bad_input("there are no rows to learn from", "x");
  if (auto status = validate_values(data); !status) return status;
  for (std::size_t j = 0; j < data.inputs; ++j) {
    if (is_constant(data, j)) {
      return base::bad_input(data.inputs == 1 ? "x is constant: a curve needs at least two different inputs"
                                              : "input " + std::to_string(j) + " is constant: leave it out",
                             "x");
    }
  }
  if (!has_distinct_inputs(data, parameters)) {
    return base::bad_input("x has " + std::to_string(distinct_inputs(data)) + " distinct values for " +
                               std::to_string(parameters) +
                               " consequent parameters: use fewer rules, order 0, or more data",
                           "x");
  }
  return {};
}

TrainingData select_rows(const TrainingData& data, const std::vector<bool>& keep) {
  assert(data.precision_factor.empty());
  TrainingData selected;
  selected.group_variance = data.group_variance;
  selected.inputs = data.inputs;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    if (!keep[i]) continue;
    selected.x.insert(selected.x.end(), data.row(i).begin(), data.row(i).end());
    selected.y.push_back(data.y[i]);
    if (!data.weight.empty()) selected.weight.push_back(data.weight[i]);
    if (!data.group.empty()) selected.group.push_back(data.group[i]);
  }
  return selected;
}

std::vector<double> residuals(const TrainingData& data, const Model& model) {
  std::vector<double> r(data.rows());
  evaluate(model, data.x, r);
  std::transform(data.y.begin(), data.y.end(), r.begin(), r.begin(), std::minus<>());
  return r;
}

double shape_rmse(const TrainingData& data, std::vector<double> residuals) {
  const double variance = data.group_variance > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
  const GroupWhitening whitening(data.rows(), data.weight, data.group, variance);
  Eigen::Map<Eigen::VectorXd> r(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  whitening.apply(r);
  return std::sqrt(r.squaredNorm() / whitening.total_weight());
}

double shape_rmse(const TrainingData& data, const Model& model) { return shape_rmse(data, residuals(data, model)); }

}  // namespace soak::anfis
