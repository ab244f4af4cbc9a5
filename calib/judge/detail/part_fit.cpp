// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/detail/part_fit.h"

#include <algorithm>
#include <utility>

#include "anfis/model/rule_base.h"
#include "anfis/select/structure_search.h"
#include "anfis/train/learner.h"
#include "calib/curve/baselines.h"

namespace soak::calib {
namespace {

constexpr int kSpareTemperatures = 2;  ///< as in fit/families.cpp
constexpr int kFewestRules = 2;

/// As curves are learned (fit/families.cpp), but for the last digits: parts scatter by far more.
anfis::VariableProjectionOptions learner() {
  anfis::VariableProjectionOptions options;
  options.smoothness = 1e-7;
  options.evaluations = 40;
  options.min_rmse_change = 1e-4;
  return options;
}

base::Result<PartCurve> fit_anfis(const anfis::TrainingData& rows, int rules, anfis::Shape shape) {
  anfis::RuleBaseOptions options;
  options.memberships = {rules};
  options.shape = shape;
  const auto initial = anfis::grid_rules(rows, options);
  if (!initial) return base::forward_error(initial);
  const auto trained = anfis::train_variable_projection(*initial, rows, learner());
  if (!trained) return base::forward_error(trained);
  return PartCurve{trained->model, static_cast<double>(rules)};
}

base::Result<PartCurve> as_part(base::Result<FittedCurve> fit) {
  if (!fit) return base::forward_error(fit);
  return PartCurve{std::move(fit->curve), std::max(1.0, fit->parameters - 1.0)};
}

}  // namespace

PartStructure structure_of(const CurveFit& fit) {
  const bool bell = fit.membership != anfis::name(anfis::Shape::gaussian);
  return {fit.deployed, fit.rules, bell ? anfis::Shape::bell : anfis::Shape::gaussian};
}

base::Result<PartCurve> fit_part(const anfis::TrainingData& rows, const PartStructure& structure) {
  if (structure.family == Family::anfis) {
    const int rules = std::min(structure.rules, (anfis::resolved_values(rows) - kSpareTemperatures) / 2);
    if (rules >= kFewestRules) return fit_anfis(rows, rules, structure.shape);
  } else if (structure.family != Family::spline) {
    auto fit = as_part(fit_polynomial(rows, structure.family == Family::poly3 ? 3 : 5));
    if (fit) return fit;
  }
  return as_part(fit_smoothing_spline(rows));
}

}  // namespace soak::calib
