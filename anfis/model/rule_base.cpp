// SPDX-License-Identifier: Apache-2.0
#include "anfis/model/rule_base.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

namespace soak::anfis {
namespace {

/// Distance from the centre at which a Gaussian of standard deviation 1 is 1/2.
const double kGaussianHalfWidth = std::sqrt(2.0 * std::numbers::ln2);

struct Range {
  double low;
  double high;
};

Range column_range(const TrainingData& data, std::size_t input) {
  Range range{data.x[input], data.x[input]};
  for (std::size_t i = 0; i < data.rows(); ++i) {
    range.low = std::min(range.low, data.row(i)[input]);
    range.high = std::max(range.high, data.row(i)[input]);
  }
  return range;
}

Scale scale_of(Range range, bool scale) {
  if (!scale) return {};
  const double half_range = 0.5 * range.high - 0.5 * range.low;
  return {0.5 * range.low + 0.5 * range.high, half_range > 0.0 ? half_range : 1.0};
}

base::Status validate_options(const RuleBaseOptions& options, std::size_t inputs) {
  if (options.order != 0 && options.order != 1) {
    return base::bad_input("order is " + std::to_string(options.order) + ": it must be 0 or 1", "order");
  }
  if (options.memberships.size() != 1 && options.memberships.size() != inputs) {
    return base::bad_input("memberships has " + std::to_string(options.memberships.size()) + " numbers for " +
                               std::to_string(inputs) + " inputs: give one for all or one per input",
                           "memberships");
  }
  for (const int count : options.memberships) {
    if (count < 2 || static_cast<std::size_t>(count) > kMostMemberships) {
      return base::bad_input(
          "memberships is " + std::to_string(count) + ": it must be 2.." + std::to_string(kMostMemberships),
          "memberships");
    }
  }
  return {};
}

std::size_t membership_count(const RuleBaseOptions& options, std::size_t input) {
  return static_cast<std::size_t>(options.memberships.size() == 1 ? options.memberships[0]
                                                                  : options.memberships[input]);
}

base::Status validate_grid_size(const RuleBaseOptions& options, std::size_t inputs) {
  double rules = 1.0;
  for (std::size_t j = 0; j < inputs; ++j) rules *= static_cast<double>(membership_count(options, j));
  if (rules <= static_cast<double>(kMostRules)) return {};
  return base::bad_input("the grid would have " + std::to_string(static_cast<long long>(std::min(rules, 1e18))) +
                             " rules, at most " + std::to_string(kMostRules) +
                             " are possible: use fewer memberships, or a rule base from fuzzy_ols()",
                         "memberships");
}

Input base_input(const TrainingData& data, std::size_t input, bool scale) {
  const Range range = column_range(data, input);
  Input result;
  result.scale = scale_of(range, scale);
  result.min = range.low;
  result.max = range.high;
  return result;
}

/// Model without memberships and rules.
Model empty_model(const TrainingData& data, const RuleBaseOptions& options) {
  Model model;
  model.order = options.order;
  model.t_norm = options.t_norm;
  for (std::size_t j = 0; j < data.inputs; ++j) model.inputs.push_back(base_input(data, j, options.scale));
  const auto [low, high] = std::minmax_element(data.y.begin(), data.y.end());
  model.output = scale_of({*low, *high}, options.scale);
  return model;
}

void add_grid_memberships(Input& input, std::size_t count, Shape shape) {
  const double low = input.scale.scaled(input.min);
  const double high = input.scale.scaled(input.max);
  const double spacing = (high - low) / static_cast<double>(count - 1);
  for (std::size_t k = 0; k < count; ++k) {
    // [Jang93] neighbours cross at 1/2: half way between their centres
    input.memberships.push_back(membership_around(shape, low + spacing * static_cast<double>(k), 0.5 * spacing));
  }
}

/// Every combination of one membership per input, the last input varying fastest.
std::vector<Rule> all_combinations(const Model& model) {
  std::vector<Rule> rules;
  std::vector<int> premise(model.inputs.size(), 0);
  for (;;) {
    rules.push_back({premise, std::vector<double>(model.inputs.size(), 0.0), 0.0, {}});
    std::size_t j = premise.size();
    while (j > 0 && ++premise[j - 1] == static_cast<int>(model.inputs[j - 1].memberships.size())) premise[--j] = 0;
    if (j == 0) return rules;
  }
}

std::vector<Eigen::Index> order_of_rules(const Eigen::MatrixXd& centres) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(centres.rows()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  if (centres.cols() == 1) {
    std::stable_sort(order.begin(), order.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return centres(a, 0) < centres(b, 0); });
  }
  return order;
}

base::Status validate_scatter(const TrainingData& data, const Eigen::MatrixXd& centres, const Eigen::MatrixXd& widths) {
  const auto inputs = static_cast<Eigen::Index>(data.inputs);
  if (centres.rows() < 1 || centres.rows() > static_cast<Eigen::Index>(kMostMemberships) || centres.cols() != inputs) {
    return base::bad_input(
        "centres must have one row per rule, 1.." + std::to_string(kMostMemberships) + ", and one column per input",
        "centres");
  }
  if (widths.rows() != centres.rows() || widths.cols() != centres.cols()) {
    return base::bad_input("widths must have as many rows and columns as centres", "widths");
  }
  if (!centres.allFinite()) return base::bad_input("centres must be finite numbers", "centres");
  if (!widths.allFinite() || (widths.array() <= 0.0).any()) {
    return base::bad_input("widths must be positive numbers", "widths");
  }
  return {};
}

/// The model, or why the data lead to none that can be evaluated.
base::Result<Model> usable(Model model) {
  if (auto status = validate(model); !status) {
    return base::bad_input(
        "the data lead to a model that cannot be evaluated (" + status.error().message + "): change their units",
        "x, y: " + status.error().where);
  }
  return model;
}

}  // namespace

Membership membership_around(Shape shape, double centre, double half_width_at_half) {
  const double h = half_width_at_half;
  switch (shape) {
    case Shape::bell:
      return bell(h, 2.0, centre);
    case Shape::gaussian:
      return gaussian(h / kGaussianHalfWidth, centre);
    case Shape::two_sided_gaussian: {
      // A top of a third of the distance to either side, the flank from there.
      const double top = h / 3.0;
      const double width = (h - top) / kGaussianHalfWidth;
      return {shape, {width, centre - top, width, centre + top}};
    }
    case Shape::triangle:
      return {shape, {centre - 2.0 * h, centre, centre + 2.0 * h, 0.0}};
    case Shape::trapezoid: {
      const double top = h / 3.0;
      return {shape, {centre - 2.0 * h + top, centre - top, centre + top, centre + 2.0 * h - top}};
    }
  }
  return {};
}

base::Result<Model> grid_rules(const TrainingData& data, const RuleBaseOptions& options) {
  if (auto status = validate(data, 0); !status) return base::forward_error(status);
  if (auto status = validate_options(options, data.inputs); !status) return base::forward_error(status);
  if (auto status = validate_grid_size(options, data.inputs); !status) return base::forward_error(status);
  Model model = empty_model(data, options);
  for (std::size_t j = 0; j < data.inputs; ++j) {
    add_grid_memberships(model.inputs[j], membership_count(options, j), options.shape);
  }
  model.rules = all_combinations(model);
  return usable(std::move(model));
}

base::Result<Model> scatter_rules(const TrainingData& data, const Eigen::MatrixXd& centres,
                                  const Eigen::MatrixXd& widths, const RuleBaseOptions& options) {
  if (auto status = validate(data, 0); !status) return base::forward_error(status);
  if (auto status = validate_options({{2}, options.shape, options.order, options.t_norm, options.scale}, data.inputs);
      !status) {
    return base::forward_error(status);
  }
  if (auto status = validate_scatter(data, centres, widths); !status) return base::forward_error(status);
  Model model = empty_model(data, options);
  for (const Eigen::Index row : order_of_rules(centres)) {
    const int index = static_cast<int>(model.rules.size());
    model.rules.push_back({std::vector<int>(data.inputs, index), std::vector<double>(data.inputs, 0.0), 0.0, {}});
    for (std::size_t j = 0; j < data.inputs; ++j) {
      Input& input = model.inputs[j];
      const auto column = static_cast<Eigen::Index>(j);
      input.memberships.push_back(membership_around(options.shape, input.scale.scaled(centres(row, column)),
                                                    kGaussianHalfWidth * widths(row, column) / input.scale.half_range));
    }
  }
  return usable(std::move(model));
}

}  // namespace soak::anfis
