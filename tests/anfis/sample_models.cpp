// SPDX-License-Identifier: Apache-2.0
#include "sample_models.h"

#include "base/random.h"
#include "support.h"

namespace soak::anfis::test {
namespace {

void randomise(Model& model, base::Random& random) {
  for (Input& input : model.inputs) {
    for (Membership& m : input.memberships) {
      for (std::size_t p = 0; p < parameter_count(m.shape); ++p) m.parameters[p] += random.uniform(-0.05, 0.05);
    }
  }
  for (Rule& rule : model.rules) {
    rule.offset = random.uniform(-1.0, 1.0);
    for (double& gain : rule.gains) gain = model.order == 1 ? random.uniform(-1.0, 1.0) : 0.0;
  }
}

std::string text(const char* kind, Shape shape, TNorm t_norm, int order) {
  std::string what(kind);
  what += ' ';
  what += name(shape);
  what += ' ';
  what += name(t_norm);
  return what + " order " + std::to_string(order);
}

}  // namespace

TrainingData random_rows(std::uint64_t seed) {
  base::Random random(seed, 31);
  TrainingData data;
  data.inputs = 2;
  for (int i = 0; i < 37; ++i) {
    // The first two rows are the corners of the range.
    const double u = i == 0 ? -1.0 : i == 1 ? 1.0 : random.uniform(-1.0, 1.0);
    const double v = i == 0 ? -1.0 : i == 1 ? 1.0 : random.uniform(-1.0, 1.0);
    data.x.insert(data.x.end(), {20.0 + 10.0 * u, -1.0 + v});
    data.y.push_back(3.0 + 2.0 * random.uniform(-1.0, 1.0));
  }
  return data;
}

Sample grid_sample(Shape shape, TNorm t_norm, int order) {
  base::Random random(7, static_cast<std::uint64_t>(shape));
  Sample sample{text("grid", shape, t_norm, order), {}, random_rows(1)};
  sample.model = *grid_rules(sample.data, {.memberships = {3, 2}, .shape = shape, .order = order, .t_norm = t_norm});
  randomise(sample.model, random);
  return sample;
}

Sample scatter_sample(Shape shape, TNorm t_norm, int order) {
  base::Random random(8, static_cast<std::uint64_t>(shape));
  Sample sample{text("scatter", shape, t_norm, order), {}, random_rows(2)};
  Eigen::MatrixXd centres(4, 2), widths(4, 2);
  centres << 15.0, -1.5, 25.0, -0.5, 20.0, -1.0, 22.0, -1.2;
  widths << 9.0, 1.1, 8.0, 0.9, 14.0, 0.8, 9.0, 1.5;
  sample.model = *scatter_rules(sample.data, centres, widths, {.shape = shape, .order = order, .t_norm = t_norm});
  randomise(sample.model, random);
  sample.model.rules[2].premise[1] = kAny;  // straight flanks of width 14 reach over the whole range
  sample.model.rules[3].premise[0] = kAny;
  if (order == 1) {
    sample.model.rules[1].dropped = {1};
    sample.model.rules[1].gains[1] = 0.0;
    sample.model.rules[3].dropped = {0, 1};
    sample.model.rules[3].gains = {0.0, 0.0};
  }
  return sample;
}

std::vector<Sample> all_samples() {
  std::vector<Sample> samples;
  for (const Shape shape : kShapes) {
    for (const TNorm t_norm : {TNorm::product, TNorm::minimum}) {
      for (const int order : {0, 1}) {
        samples.push_back(grid_sample(shape, t_norm, order));
        samples.push_back(scatter_sample(shape, t_norm, order));
      }
    }
  }
  return samples;
}

}  // namespace soak::anfis::test
