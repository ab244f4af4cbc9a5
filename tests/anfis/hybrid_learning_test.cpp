// SPDX-License-Identifier: Apache-2.0
#include "anfis/hybrid_learning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/random.h"
#include "support.h"

namespace soak::anfis {
namespace {

using Real = long double;
using Matrix = std::vector<std::vector<Real>>;

// A second implementation of hybrid learning: dense V^-1, normal equations, differences for derivatives, plain loops.
class PlainLearner {
 public:
  PlainLearner(const TrainingData& data, const HybridOptions& options) : options_(options) {
    const auto [xl, xh] = std::minmax_element(data.x.begin(), data.x.end());
    const auto [yl, yh] = std::minmax_element(data.y.begin(), data.y.end());
    half_range_ = (Real{*yh} - *yl) / 2;
    for (std::size_t i = 0; i < data.rows(); ++i) {
      u_.push_back((Real{data.x[i]} - (Real{*xl} + *xh) / 2) / ((Real{*xh} - *xl) / 2));
      y_.push_back((Real{data.y[i]} - (Real{*yl} + *yh) / 2) / half_range_);
    }
    Matrix v(data.rows(), std::vector<Real>(data.rows()));
    for (std::size_t i = 0; i < data.rows(); ++i) {
      for (std::size_t k = 0; k < data.rows(); ++k) {
        v[i][k] = data.group[i] == data.group[k] ? Real{data.group_variance} : 0;
      }
      v[i][i] += 1 / Real{data.weight[i]};
      total_weight_ += data.weight[i];
    }
    Matrix identity(data.rows(), std::vector<Real>(data.rows()));
    for (std::size_t i = 0; i < data.rows(); ++i) {
      identity[i][i] = 1;
    }
    inverse_ = solve(v, identity);
    const Real spacing = Real{2} / (options.rules - 1);
    for (int i = 0; i < options.rules; ++i) {
      const Real a = spacing / 2;
      const bool bell = options.membership == Membership::bell;
      premises_.push_back(
          {bell ? a : a / std::sqrt(2 * std::log(Real{2})), bell ? Real{2} : Real{0}, -1 + i * spacing});
    }
  }

  struct Epoch {
    double rmse;
    double step;
  };

  std::vector<Epoch> learn() {
    std::vector<Epoch> history;
    double step = options_.initial_step;
    int last_up = 0, last_down = 0;
    for (int epoch = 0; epoch < options_.epochs; ++epoch) {
      solve_consequents();
      history.push_back({static_cast<double>(half_range_ * std::sqrt(error() / total_weight_)), step});
      move(step);
      const auto rmse = [&](int back) { return history[static_cast<std::size_t>(epoch - back)].rmse; };
      const auto fell = [&](int back) { return epoch >= back && rmse(back - 1) < rmse(back); };
      const auto rose = [&](int back) { return epoch >= back && rmse(back - 1) > rmse(back); };
      if (epoch - last_down >= 4 && fell(1) && rose(2) && fell(3) && rose(4)) {
        step *= options_.step_decrease;
        last_down = epoch;
      } else if (epoch - last_up >= 4 && fell(1) && fell(2) && fell(3) && fell(4)) {
        step *= options_.step_increase;
        last_up = epoch;
      }
    }
    return history;
  }

 private:
  static Matrix solve(Matrix a, Matrix b) {  // Gauss-Jordan with pivoting
    const std::size_t n = a.size();
    for (std::size_t c = 0; c < n; ++c) {
      std::size_t p = c;
      for (std::size_t r = c; r < n; ++r) {
        p = std::abs(a[r][c]) > std::abs(a[p][c]) ? r : p;
      }
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

  std::vector<Real> regressors(Real u) const {
    std::vector<Real> strength;
    Real sum = 0;
    for (const auto& [width, slope, centre] : premises_) {
      const Real t = (u - centre) / width;
      strength.push_back(options_.membership == Membership::bell ? 1 / (1 + std::pow(std::abs(t), 2 * slope))
                                                                 : std::exp(-t * t / 2));
      sum += strength.back();
    }
    std::vector<Real> row;
    for (Real s : strength) {
      row.push_back(s / sum);
      if (options_.order == 1) row.push_back(s / sum * u);
    }
    return row;
  }

  std::vector<Real> residuals() const {
    std::vector<Real> r;
    for (std::size_t i = 0; i < u_.size(); ++i) {
      const std::vector<Real> row = regressors(u_[i]);
      Real f = 0;
      for (std::size_t k = 0; k < row.size(); ++k) f += row[k] * consequents_[k];
      r.push_back(y_[i] - f);
    }
    return r;
  }

  Real error() const {
    const std::vector<Real> r = residuals();
    Real e = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      for (std::size_t k = 0; k < r.size(); ++k) e += r[i] * inverse_[i][k] * r[k];
    }
    return e;
  }

  void solve_consequents() {
    Matrix a;
    for (Real u : u_) a.push_back(regressors(u));
    const std::size_t m = a[0].size();
    Matrix va(a.size(), std::vector<Real>(m)), normal(m, std::vector<Real>(m)), right(m, std::vector<Real>(1));
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t k = 0; k < a.size(); ++k) {
        for (std::size_t c = 0; c < m; ++c) va[i][c] += inverse_[i][k] * a[k][c];
      }
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t c = 0; c < m; ++c) {
        for (std::size_t d = 0; d < m; ++d) normal[c][d] += a[i][c] * va[i][d];
        right[c][0] += va[i][c] * y_[i];
      }
    }
    consequents_.clear();
    for (const auto& row : solve(normal, right)) consequents_.push_back(row[0]);
  }

  void move(Real step) {
    const Real h = 1e-6L;
    std::vector<std::array<Real, 3>> descent(premises_.size());
    Real norm = 0;
    for (std::size_t i = 0; i < premises_.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (options_.membership == Membership::gaussian && k == 1) continue;
        const Real value = premises_[i][k];
        premises_[i][k] = value + h;
        const Real above = error();
        premises_[i][k] = value - h;
        descent[i][k] = -(above - error()) / (2 * h);
        premises_[i][k] = value;
      }
      Real& along = descent[i][2];
      if ((premises_[i][2] <= -1 && along < 0) || (premises_[i][2] >= 1 && along > 0)) along = 0;
      for (Real d : descent[i]) norm += d * d;
    }
    for (std::size_t i = 0; i < premises_.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) premises_[i][k] += step * descent[i][k] / std::sqrt(norm);
      premises_[i][2] = std::clamp<Real>(premises_[i][2], -1, 1);
    }
  }

  HybridOptions options_;
  std::vector<Real> u_, y_;
  Matrix inverse_;
  Real half_range_ = 0, total_weight_ = 0;
  std::vector<std::array<Real, 3>> premises_;
  std::vector<Real> consequents_;
};

TrainingData dense_rows(int rows) {
  base::Random random(3);
  TrainingData data;
  for (int i = 0; i < rows; ++i) {
    const double x = 10.0 + 80.0 * i / (rows - 1);
    data.x.push_back(x);
    data.y.push_back(std::sin(x / 15.0) + 0.003 * x + 0.5 * (i % 3) + 0.01 * random.gaussian());
    data.weight.push_back(1.0 + 0.5 * (i % 4));
    data.group.push_back(i % 3);
  }
  data.group_variance = 0.4;
  return data;
}

TEST(HybridLearning, FollowsAPlainSecondImplementationEpochByEpoch) {
  const TrainingData data = dense_rows(60);
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    for (const int order : {0, 1}) {
      HybridOptions options;
      options.rules = 4;
      options.order = order;
      options.membership = membership;
      options.epochs = 30;
      const auto training = train_hybrid(data, options);
      ASSERT_TRUE(training);
      const auto expected = PlainLearner(data, options).learn();
      ASSERT_EQ(training->summary.history.size(), expected.size());
      bool step_changed = false;
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const EpochRecord& got = training->summary.history[i];
        // The differences of the second implementation are good to 1e-9 of the gradient; steps add up over epochs.
        EXPECT_NEAR(got.train_rmse / expected[i].rmse, 1.0, 1e-7) << name(membership) << order << " epoch " << i + 1;
        EXPECT_DOUBLE_EQ(got.step, expected[i].step);
        step_changed = step_changed || got.step != options.initial_step;
      }
      EXPECT_TRUE(step_changed);
    }
  }
}

// Worst error over the range of a model trained on 151 exact values of `known`, as a share of the span.
double recovery_error(const Model& known, double low, double high, int rules) {
  TrainingData data;
  for (int i = 0; i <= 150; ++i) {
    data.x.push_back(low + (high - low) * i / 150.0);
    data.y.push_back(evaluate(known, data.x.back()));
  }
  HybridOptions options;
  options.rules = rules;
  const auto training = train_hybrid(data, options);
  EXPECT_TRUE(training);
  double worst = 0.0;
  for (int i = 0; i <= 1200; ++i) {
    const double x = low + (high - low) * i / 1200.0;
    worst = std::max(worst, std::abs(evaluate(training->model, x) - evaluate(known, x)));
  }
  const auto [least, most] = std::minmax_element(data.y.begin(), data.y.end());
  return worst / (*most - *least);
}

TEST(HybridLearning, RecoversTheFunctionOfAKnownSystemNearTheStartingGrid) {
  Model known;
  known.input_centre = 20.0;
  known.input_half_range = 50.0;
  known.rules = {{0.5, 2.0, -0.95, 0.3, -0.4}, {0.45, 2.2, 0.05, -0.8, 0.2}, {0.55, 1.8, 0.95, 0.5, 0.1}};
  EXPECT_LT(recovery_error(known, -30.0, 70.0, 3),
            1e-3);  // the least squares of the first epoch alone leave ten times more
}

// The memberships of this system are a third as wide as those of a grid of three: with three rules steepest descent
// crawls along a narrow valley (5 % of the span after 100 epochs, 7 % after 1000). More rules represent the function
// all the same.
TEST(HybridLearning, RecoversTheFunctionOfASystemFarFromTheGridWithMoreRules) {
  const auto v = nlohmann::json::parse(test::read_vector_file("fis_bell_1in.json"));
  Model known;
  for (std::size_t i = 0; i < v["a"].size(); ++i) {
    known.rules.push_back({v["a"][i], v["b"][i], v["c"][i], v["consequents_slope"][i], v["consequents_offset"][i]});
  }
  const double three = recovery_error(known, -60.0, 90.0, 3);
  const double seven = recovery_error(known, -60.0, 90.0, 7);
  std::printf("known system far from the grid, worst error of the span: 3 rules %.4f, 7 rules %.4f\n", three, seven);
  EXPECT_LT(seven, 0.01);
}

// Each run covers only part of the range, the warm ones with a large offset: without the random intercept the offset
// goes into the curve.
TEST(HybridLearning, RandomInterceptsKeepRunOffsetsOutOfTheCurve) {
  base::Random random(8);
  TrainingData data;
  const auto truth = [](double x) { return 0.2 * std::sin(x / 20.0); };
  for (int run = 0; run < 8; ++run) {
    const double offset = run % 2 == 0 ? 0.5 : -0.5;
    for (int i = 0; i < 14; ++i) {
      const double x = (run % 2 == 0 ? 0.0 : 35.0) + 5.0 * i;
      data.x.push_back(x);
      data.y.push_back(truth(x) + offset + 0.002 * random.gaussian());
      data.group.push_back(run);
    }
  }
  const auto worst_shape = [&](double group_variance) {
    data.group_variance = group_variance;
    HybridOptions options;
    options.rules = 4;
    const auto training = train_hybrid(data, options);
    EXPECT_TRUE(training);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (double x = 0.0; x <= 100.0; x += 1.0) {
      const double e = evaluate(training->model, x) - truth(x);
      low = std::min(low, e);
      high = std::max(high, e);
    }
    return 0.5 * (high - low);
  };
  EXPECT_GT(worst_shape(0.0), 0.2);
  EXPECT_LT(worst_shape(0.25 / (0.002 * 0.002)), 0.01);
  EXPECT_LT(worst_shape(std::numeric_limits<double>::infinity()), 0.01);
}

TEST(HybridLearning, FreeOffsetsLeaveTheLevelAtTheMeanOfTheRuns) {
  auto problem = test::drift_problem(2, 4);
  problem.data.group_variance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < problem.data.rows(); ++i) {
    problem.data.y[i] += 7.0 + (problem.data.group[i] == 0 ? 4.0 : 0.0);  // mean of the runs: 8
  }
  const auto training = train_hybrid(problem.data, {});
  ASSERT_TRUE(training);
  double level = 0.0;
  for (double t = -30.0; t <= 70.0; t += 5.0) {
    level += (evaluate(training->model, t) - problem.truth(t)) / 21.0;
  }
  EXPECT_NEAR(level, 8.0, 0.03);  // run offsets sigma 0.02 / sqrt(4)
}

TEST(HybridLearning, KeepsTheModelOfTheLeastCheckingError) {
  const TrainingData train = test::gyro_drift(true);
  TrainingData check = test::gyro_drift(false);
  HybridOptions options;
  options.rules = 10;
  const auto training = train_hybrid(train, options, &check);
  ASSERT_TRUE(training);
  const auto& history = training->summary.history;
  const auto least = std::min_element(history.begin(), history.end(),
                                      [](const auto& a, const auto& b) { return a.check_rmse < b.check_rmse; });
  EXPECT_EQ(training->summary.best_epoch, least - history.begin() + 1);
  EXPECT_EQ(training->summary.check_rmse, least->check_rmse);
  EXPECT_NE(training->summary.best_epoch, static_cast<int>(history.size()));
  double sum = 0.0;
  for (std::size_t i = 0; i < check.rows(); ++i) {
    sum += std::pow(check.y[i] - evaluate(training->model, check.x[i]), 2);
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(check.rows())), least->check_rmse, 1e-12);
  check.group_variance = 1.0;
  EXPECT_LT(train_hybrid(train, options, &check)->summary.check_rmse, 0.8 * least->check_rmse);  // shape error
}

TEST(HybridLearning, GivesTheSameBitsTwice) {
  const auto problem = test::drift_problem(4, 4);
  const auto first = train_hybrid(problem.data, {});
  const auto second = train_hybrid(problem.data, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->model, second->model);
}

TEST(HybridLearning, DoesNotDependOnUnits) {
  const auto problem = test::drift_problem(4, 4);
  TrainingData scaled = problem.data;
  for (std::size_t i = 0; i < scaled.rows(); ++i) {
    scaled.x[i] = scaled.x[i] * 1.8 + 32.0;
    scaled.y[i] *= 3600.0;
    scaled.weight[i] /= 3600.0 * 3600.0;
  }
  scaled.group_variance *= 3600.0 * 3600.0;
  HybridOptions options;
  options.epochs = 20;
  const auto plain = train_hybrid(problem.data, options);
  const auto other = train_hybrid(scaled, options);
  ASSERT_TRUE(plain && other);
  for (double t = -30.0; t <= 70.0; t += 1.0) {
    EXPECT_NEAR(evaluate(other->model, t * 1.8 + 32.0) / 3600.0, evaluate(plain->model, t), 1e-8);
  }
}

TEST(HybridLearning, SaysWhyItStopped) {
  const auto problem = test::drift_problem(1, 4);
  HybridOptions options;
  options.epochs = 12;
  auto training = train_hybrid(problem.data, options);
  EXPECT_EQ(training->summary.reason, StopReason::epochs_done);
  EXPECT_NE(training->summary.one_line().find("epochs done after 12 epochs"), std::string::npos);
  options.rmse_goal = 1.0;
  training = train_hybrid(problem.data, options);
  EXPECT_EQ(training->summary.reason, StopReason::goal_reached);
  EXPECT_EQ(training->summary.history.size(), 1U);
  options.rmse_goal = 0.0;
  options.epochs = 1000;
  options.min_rmse_change = 0.01;
  training = train_hybrid(problem.data, options);
  EXPECT_EQ(training->summary.reason, StopReason::converged);
  EXPECT_LT(training->summary.history.size(), 1000U);
  TrainingData zero = problem.data;
  std::fill(zero.y.begin(), zero.y.end(), 0.0);
  training = train_hybrid(zero, {});
  EXPECT_EQ(training->summary.reason, StopReason::goal_reached);  // an error of 0 meets every goal
  EXPECT_EQ(evaluate(training->model, 20.0), 0.0);
}

TEST(HybridLearning, NeverHoldsAValueThatIsNotFinite) {
  const auto finite = [](const TrainingData& data, const HybridOptions& options) {
    const auto training = train_hybrid(data, options);
    return !training                   ? training.error().message
           : validate(training->model) ? ""
                                       : validate(training->model).error().message;
  };
  for (const Membership membership : {Membership::bell, Membership::gaussian}) {
    HybridOptions options;
    options.membership = membership;
    options.initial_step = 1.0;  // a step of half the range in every epoch
    options.step_increase = 2.0;
    options.epochs = 300;
    options.rules = 8;
    EXPECT_EQ(finite(test::drift_problem(6, 4).data, options), "");
    TrainingData outlier = test::drift_problem(6, 4).data;
    outlier.y[30] = 1e30;
    EXPECT_EQ(finite(outlier, options), "");
    TrainingData sparse{{0.0, 1.0, 1.0 + 1e-12, 1000.0}, {1.0, 2.0, -2.0, 0.0}, {}, {}, 0.0};
    options.rules = 2;
    EXPECT_EQ(finite(sparse, options), "");
  }
  TrainingData huge{{-1.7e308, 0.0, 1.0, 1.7e308}, {-1.7e308, 0.0, 1.0, 1.7e308}, {}, {}, 0.0};
  HybridOptions two;
  two.rules = 2;
  const auto training = train_hybrid(huge, two);
  EXPECT_TRUE(!training || validate(training->model));
}

TEST(HybridLearning, RefusesOptionsOutOfRangeByName) {
  const auto where_of = [](auto&& change) {
    HybridOptions options;
    change(options);
    const auto training = train_hybrid(test::drift_problem(1, 2).data, options);
    return training ? std::string("accepted") : training.error().where;
  };
  EXPECT_EQ(where_of([](auto&) {}), "accepted");
  EXPECT_EQ(where_of([](auto& o) { o.rules = 1; }), "rules");
  EXPECT_EQ(where_of([](auto& o) { o.order = 2; }), "order");
  EXPECT_EQ(where_of([](auto& o) { o.epochs = 0; }), "epochs");
  EXPECT_EQ(where_of([](auto& o) { o.initial_step = 0.0; }), "initial_step");
  EXPECT_EQ(where_of([](auto& o) { o.step_decrease = 1.5; }), "step_decrease");
  EXPECT_EQ(where_of([](auto& o) { o.step_increase = 0.9; }), "step_increase");
  EXPECT_EQ(where_of([](auto& o) { o.rmse_goal = std::nan(""); }), "rmse_goal");
  EXPECT_EQ(where_of([](auto& o) { o.min_rmse_change = 1.0; }), "min_rmse_change");
  EXPECT_EQ(where_of([](auto& o) { o.rules = 40; }), "x");  // 80 consequents, 42 distinct inputs
}

}  // namespace
}  // namespace soak::anfis
