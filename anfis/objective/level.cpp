// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/level.h"

#include <cmath>
#include <map>

namespace soak::anfis::training {

void set_level(Model& model, const TrainingData& data) {
  if (!std::isinf(data.group_variance)) return;
  struct Sum {
    double weighted = 0.0;
    double weight = 0.0;
  };
  const std::vector<double> r = residuals(data, model);
  std::map<int, Sum> sums;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const double weight = data.weight.empty() ? 1.0 : data.weight[i];
    Sum& sum = sums[data.group[i]];
    sum.weighted += weight * r[i];
    sum.weight += weight;
  }
  double level = 0.0;
  for (const auto& [group, sum] : sums) level += sum.weighted / sum.weight / static_cast<double>(sums.size());
  for (Rule& rule : model.rules) rule.offset += level / model.output.half_range;
}

}  // namespace soak::anfis::training
