// SPDX-License-Identifier: Apache-2.0
#include "anfis/premises/premise_coordinates.h"

#include <gtest/gtest.h>

#include <cmath>

#include "anfis/premises/premise_bounds.h"
#include "base/random.h"
#include "sample_models.h"
#include "support.h"

namespace soak::anfis::training {
namespace {

std::vector<double> premises(const Model& model) {
  std::vector<double> theta(premise_count(model));
  read_premises(model, theta);
  return theta;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// 7 x 7 evenly spaced rows over the ranges of random_rows().
TrainingData even_rows() {
  TrainingData data;
  data.inputs = 2;
  for (int i = 0; i < 49; ++i) {
    data.x.insert(data.x.end(), {10.0 + 20.0 * (i / 7) / 6.0, -2.0 + 2.0 * (i % 7) / 6.0});
    data.y.push_back(0.0);
  }
  return data;
}

/// All samples, their rows replaced by even ones, made admissible.
std::vector<test::Sample> admissible_samples(PremiseLimits limits) {
  std::vector<test::Sample> samples = test::all_samples();
  for (test::Sample& sample : samples) {
    sample.data = even_rows();
    PremiseBounds(sample.model, sample.data, limits).apply(sample.model);
  }
  return samples;
}

constexpr PremiseLimits kLimits[] = {PremiseLimits::resolved, PremiseLimits::ordered};

// Exponentials of logarithms lose up to 4 * 2e-16, positions nothing. Tops of neighbours do not overlap here: a top
// that reaches into a neighbour's cell would be cut.
TEST(PremiseCoordinates, AdmissiblePremisesComeBack) {
  for (const PremiseLimits limits : kLimits) {
    for (const test::Sample& sample : admissible_samples(limits)) {
      const PremiseCoordinates coordinates(sample.model, {sample.model, sample.data, limits});
      Model back = sample.model;
      coordinates.set(coordinates.of(sample.model), back);
      EXPECT_LT(largest_difference(premises(back), premises(sample.model)), 1e-14) << sample.what;
    }
  }
}

std::vector<double> random_point(const PremiseCoordinates& coordinates, base::Random& random) {
  std::vector<double> z = coordinates.lowest();
  for (std::size_t i = 0; i < z.size(); ++i) {
    const double low = coordinates.lowest()[i], high = coordinates.highest()[i];
    // A quarter of the coordinates lie on each end of their interval.
    const double share = random.uniform(-0.5, 1.5);
    z[i] = share <= 0.0 ? low : share >= 1.0 ? high : low + share * (high - low);
  }
  return z;
}

/// How far PremiseBounds::apply moves the premises at random points of the box.
double inadmissibility(const test::Sample& sample, PremiseLimits limits) {
  base::Random random(6);
  const PremiseBounds bounds(sample.model, sample.data, limits);
  const PremiseCoordinates coordinates(sample.model, bounds);
  double moved = 0.0;
  for (int i = 0; i < 200; ++i) {
    Model model = sample.model;
    coordinates.set(random_point(coordinates, random), model);
    EXPECT_TRUE(validate(model)) << sample.what;
    const std::vector<double> at = premises(model);
    bounds.apply(model);
    moved = std::max(moved, largest_difference(at, premises(model)));
  }
  return moved;
}

TEST(PremiseCoordinates, EveryPointOfTheBoxIsAdmissible) {
  for (const PremiseLimits limits : kLimits) {
    for (const test::Sample& sample : admissible_samples(limits)) {
      EXPECT_LT(inadmissibility(sample, limits), 1e-12) << sample.what;
    }
  }
}

TEST(PremiseCoordinates, EveryPointOfTheBoxIsAdmissibleWhereInputsAreRandom) {
  for (test::Sample sample : test::all_samples()) {
    PremiseBounds(sample.model, sample.data).apply(sample.model);
    EXPECT_LT(inadmissibility(sample, PremiseLimits::resolved), 1e-12) << sample.what;
  }
}

// A function of the premises with a known gradient: sum_p c_p theta_p + theta_p^2. Differences with h = 1e-6 against
// second derivatives of up to 16 (e^(2 z)), h^2/6 E''' = 1e-11, rounding 1e-14/h = 1e-8.
TEST(PremiseCoordinates, ChainAgreesWithDifferences) {
  constexpr double kStep = 1e-6;
  base::Random random(7);
  for (const PremiseLimits limits : kLimits) {
    for (const test::Sample& sample : admissible_samples(limits)) {
      const PremiseCoordinates coordinates(sample.model, {sample.model, sample.data, limits});
      const auto value = [&](const std::vector<double>& z) {
        Model model = sample.model;
        coordinates.set(z, model);
        const std::vector<double> theta = premises(model);
        double e = 0.0;
        for (std::size_t p = 0; p < theta.size(); ++p)
          e += std::sin(static_cast<double>(p)) * theta[p] + theta[p] * theta[p];
        return e;
      };
      std::vector<double> z = coordinates.lowest();
      for (std::size_t i = 0; i < z.size(); ++i) {
        z[i] += random.uniform(0.05, 0.95) * (coordinates.highest()[i] - z[i]);
      }
      Model model = sample.model;
      coordinates.set(z, model);
      std::vector<double> by_theta = premises(model), by_z(z.size());
      for (std::size_t p = 0; p < z.size(); ++p) by_theta[p] = std::sin(static_cast<double>(p)) + 2.0 * by_theta[p];
      coordinates.chain(z, by_theta, by_z);
      for (std::size_t i = 0; i < z.size(); ++i) {
        std::vector<double> low = z, high = z;
        low[i] -= kStep;
        high[i] += kStep;
        EXPECT_NEAR(by_z[i], (value(high) - value(low)) / (2.0 * kStep), 5e-8) << sample.what << ' ' << i;
      }
    }
  }
}

TEST(PremiseCoordinates, PositionsTouchTheirNeighboursCellsButNotTheEndsOfTheRange) {
  const TrainingData data = test::drift_problem(3, 4).data;
  const Model model = test::grid(data, 3, Shape::gaussian);
  const PremiseCoordinates coordinates(model, PremiseBounds(model, data));
  std::vector<double> z = coordinates.of(model);  // ln width, centre of each
  EXPECT_FALSE(coordinates.touches_neighbour(z));
  z[1] = coordinates.lowest()[1];
  z[5] = coordinates.highest()[5];
  EXPECT_NEAR(z[1], -1.0, 1e-15);
  EXPECT_FALSE(coordinates.touches_neighbour(z));
  z[3] = coordinates.lowest()[3];
  EXPECT_TRUE(coordinates.touches_neighbour(z));
  z[3] = 0.0;
  z[1] = coordinates.highest()[1];
  EXPECT_TRUE(coordinates.touches_neighbour(z));
}

TEST(PremiseCoordinates, OfMembershipsOfTheirOwnTouchNothing) {
  const test::Sample sample = test::scatter_sample(Shape::bell, TNorm::product, 1);
  const PremiseCoordinates coordinates(sample.model, PremiseBounds(sample.model, sample.data));
  EXPECT_FALSE(coordinates.touches_neighbour(coordinates.lowest()));
  EXPECT_FALSE(coordinates.touches_neighbour(coordinates.highest()));
}

}  // namespace
}  // namespace soak::anfis::training
