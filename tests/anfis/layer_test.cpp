// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/layer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/objective/consequents.h"
#include "anfis/premises/premise_bounds.h"
#include "base/random.h"
#include "sample_models.h"

namespace soak::anfis::training {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A layer after its forward pass.
Layer forward(const Model& model, const TrainingData& data) {
  Layer layer(model, data);
  layer.compute(model);
  layer.compute_output(model);
  return layer;
}

/// Scaled outputs by the other implementation: evaluate(), point by point.
VectorXd scaled_outputs(const Model& model, const TrainingData& data) {
  VectorXd f(static_cast<Index>(data.rows()));
  for (std::size_t i = 0; i < data.rows(); ++i) {
    f(static_cast<Index>(i)) = model.output.scaled(evaluate(model, data.row(i)));
  }
  return f;
}

/// df/d theta by central differences of evaluate().
MatrixXd difference_jacobian(const Model& model, const TrainingData& data, double step) {
  std::vector<double> theta(premise_count(model));
  read_premises(model, theta);
  MatrixXd jacobian(static_cast<Index>(data.rows()), static_cast<Index>(theta.size()));
  for (std::size_t p = 0; p < theta.size(); ++p) {
    Model low = model, high = model;
    std::vector<double> moved = theta;
    moved[p] = theta[p] - step;
    set_premises(moved, low);
    moved[p] = theta[p] + step;
    set_premises(moved, high);
    jacobian.col(static_cast<Index>(p)) = (scaled_outputs(high, data) - scaled_outputs(low, data)) / (2.0 * step);
  }
  return jacobian;
}

// Steps of 1e-5: the truncation h^2/6 f''' with f''' up to 1e3 (widths from 0.25 on) is 2e-8, the rounding of
// evaluate() 1e-15/1e-5 = 1e-10. No row of the samples lies within 1e-5 of a kink.
TEST(Layer, JacobianAgreesWithDifferencesOfEvaluate) {
  for (const test::Sample& sample : test::all_samples()) {
    ASSERT_TRUE(validate(sample.model)) << sample.what;
    Layer layer = forward(sample.model, sample.data);
    const MatrixXd jacobian = layer.jacobian(sample.model);
    const MatrixXd difference = difference_jacobian(sample.model, sample.data, 1e-5);
    ASSERT_EQ(jacobian.rows(), difference.rows());
    ASSERT_EQ(jacobian.cols(), difference.cols());
    EXPECT_GT(jacobian.norm(), 0.1) << sample.what;
    EXPECT_LT((jacobian - difference).cwiseAbs().maxCoeff(), 1e-7) << sample.what;
  }
}

TEST(Layer, GradientIsTheTransposedJacobianTimesTheVector) {
  for (const test::Sample& sample : test::all_samples()) {
    Layer layer = forward(sample.model, sample.data);
    base::Random random(4);
    VectorXd v = VectorXd::Zero(layer.padded_rows());
    for (Index i = 0; i < static_cast<Index>(layer.rows()); ++i) v(i) = random.gaussian();
    std::vector<double> gradient(premise_count(sample.model));
    layer.gradient(sample.model, v, gradient);
    const VectorXd expected = layer.jacobian(sample.model).transpose() * v.head(static_cast<Index>(layer.rows()));
    for (std::size_t p = 0; p < gradient.size(); ++p) {
      // 37 terms of at most |v| |df/d theta| ~ 3 * 5.
      EXPECT_NEAR(gradient[p], expected(static_cast<Index>(p)), 1e-13) << sample.what << ' ' << p;
    }
  }
}

TEST(Layer, OutputIsThatOfEvaluate) {
  for (const test::Sample& sample : test::all_samples()) {
    const Layer layer = forward(sample.model, sample.data);
    const VectorXd f = layer.output().head(static_cast<Index>(layer.rows()));
    EXPECT_LT((f - scaled_outputs(sample.model, sample.data)).cwiseAbs().maxCoeff(), 1e-14) << sample.what;
  }
}

VectorXd consequents(const Model& model) {
  std::vector<double> x;
  for_each_consequent(model, [&](std::size_t i, int j) {
    x.push_back(j < 0 ? model.rules[i].offset : model.rules[i].gains[static_cast<std::size_t>(j)]);
  });
  return VectorXd::Map(x.data(), static_cast<Index>(x.size()));
}

TEST(Layer, ConsequentMatrixTimesConsequentsIsTheOutputOfTheModel) {
  for (const test::Sample& sample : test::all_samples()) {
    Layer layer(sample.model, sample.data);
    layer.compute(sample.model);
    MatrixXd a(layer.padded_rows(), static_cast<Index>(consequent_count(sample.model)));
    layer.consequent_matrix(sample.model, a);
    const VectorXd f = (a * consequents(sample.model)).head(static_cast<Index>(layer.rows()));
    EXPECT_LT((f - scaled_outputs(sample.model, sample.data)).cwiseAbs().maxCoeff(), 1e-14) << sample.what;
  }
}

TEST(Layer, StrengthsAreThoseOfTheModelAndPaddingRepeatsTheLastRow) {
  for (const test::Sample& sample : test::all_samples()) {
    const Layer layer = forward(sample.model, sample.data);
    ASSERT_EQ(layer.padded_rows(), 40);
    std::vector<double> strengths(sample.model.rules.size());
    for (Index row = 0; row < layer.padded_rows(); ++row) {
      const std::size_t of = std::min<std::size_t>(static_cast<std::size_t>(row), sample.data.rows() - 1);
      firing_strengths(sample.model, sample.data.row(of), strengths);
      for (std::size_t i = 0; i < strengths.size(); ++i) {
        EXPECT_NEAR(layer.strengths()(row, static_cast<Index>(i)), strengths[i], 1e-15) << sample.what;
      }
    }
  }
}

// The same 32 rows alone, where nothing is padded, and followed by five more.
TEST(Layer, PaddingDoesNotTouchOtherRows) {
  const test::Sample sample = test::grid_sample(Shape::bell, TNorm::product, 1);
  std::vector<bool> first(sample.data.rows(), true);
  std::fill(first.begin() + 32, first.end(), false);
  Layer few = forward(sample.model, select_rows(sample.data, first));
  Layer all = forward(sample.model, sample.data);
  EXPECT_EQ(few.padded_rows(), 32);
  EXPECT_EQ(few.output(), all.output().head(32));
  EXPECT_EQ(few.jacobian(sample.model), all.jacobian(sample.model).topRows(32));
}

// Rows 1 and 2 lie between and beyond the supports; nothing fires there.
test::Sample silent_rows(Shape shape) {
  test::Sample sample;
  sample.what = name(shape);
  sample.model.inputs.resize(1);
  const auto narrow = [&](double c) {
    return shape == Shape::gaussian ? gaussian(0.01, c) : Membership{Shape::triangle, {c - 0.05, c, c + 0.05}};
  };
  sample.model.inputs[0].memberships = {narrow(-0.5), narrow(0.5)};
  sample.model.rules = {{{0}, {1.0}, 0.5, {}}, {{1}, {-2.0}, 0.25, {}}};
  sample.data = {{-0.51, 0.1, 0.9, 0.48}, {0.0, 0.0, 0.0, 0.0}};
  return sample;
}

// Far from all centres every degree underflows; the minimum is decided by the logarithms, and so must the derivatives
// be: here by the second input, of which the rules are farther.
TEST(Layer, WhereNoRuleFiresTheMinimumFollowsTheInputThatDecides) {
  Model model;
  model.t_norm = TNorm::minimum;
  for (const double far : {3.0, 4.0}) {
    Input input;
    input.memberships = {gaussian(0.05, -far), gaussian(0.06, far)};
    input.min = -1.0;
    input.max = 1.0;
    model.inputs.push_back(input);
  }
  model.rules = {{{0, 0}, {0.0, 0.0}, 1.0, {}}, {{1, 1}, {0.0, 0.0}, -2.0, {}}};
  TrainingData data;
  data.inputs = 2;
  // ln w = -(u - c)^2 / (2 sigma^2): equal for both rules at u = -0.363636, where the output goes from one to the
  // other.
  data.x = {0.0, -0.36363};
  data.y = {0.0};
  Layer layer(model, data);
  layer.compute(model);
  layer.compute_output(model);
  const Eigen::MatrixXd jacobian = layer.jacobian(model);
  const double h = 1e-7;
  std::size_t column = 0;
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t p = 0; p < 2; ++p, ++column) {
        const auto at = [&](double by) {
          Model moved = model;
          moved.inputs[j].memberships[k].parameters[p] += by;
          return evaluate(moved, data.row(0));
        };
        const double difference = (at(h) - at(-h)) / (2.0 * h);
        // Truncation: third derivatives are of the size of the cube of the slopes, 1e3^3, times h^2.
        EXPECT_NEAR(jacobian(0, static_cast<Eigen::Index>(column)), difference, 1e-4 * (1.0 + std::abs(difference)))
            << j << k << p;
        if (j == 1) {
          EXPECT_GT(std::abs(difference), 1.0);
        }
      }
    }
  }
}

TEST(Layer, WhereNoRuleFiresTheNearestRemains) {
  for (const Shape shape : {Shape::gaussian, Shape::triangle}) {
    const test::Sample sample = silent_rows(shape);
    Layer layer = forward(sample.model, sample.data);
    EXPECT_EQ(layer.output()(1), -2.0 * 0.1 + 0.25) << sample.what;
    EXPECT_EQ(layer.output()(2), -2.0 * 0.9 + 0.25) << sample.what;
    EXPECT_TRUE(layer.output().allFinite());
    const MatrixXd jacobian = layer.jacobian(sample.model);
    EXPECT_TRUE(jacobian.allFinite());
    EXPECT_EQ(jacobian.row(1).norm(), 0.0) << sample.what;  // one rule alone: its premise does not matter
    EXPECT_LT((layer.output().head(4) - scaled_outputs(sample.model, sample.data)).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace soak::anfis::training
