// SPDX-License-Identifier: Apache-2.0
#include "support.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "base/random.h"

namespace soak::anfis::test {

std::string read_vector_file(const std::string& name) {
  std::string path = SOAK_TEST_FOLDER "/data/vectors/";
  path += name;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error("missing test vector " + name);
  }
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Model grid(const TrainingData& data, int memberships, Shape shape, int order) {
  const auto model = grid_rules(data, {.memberships = {memberships}, .shape = shape, .order = order});
  if (!model) {
    throw std::runtime_error(model.error().message);
  }
  return *model;
}

TrainingData gyro_drift(bool training_runs) {
  std::istringstream lines(read_vector_file("gyro_drift_21x20.csv"));
  std::string line;
  std::getline(lines, line);
  TrainingData data;
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(fields, cell, ',');) {
      cells.push_back(cell);
    }
    if ((cells.at(1) == "train") == training_runs) {
      data.group.push_back(std::stoi(cells.at(0)));
      data.x.push_back(std::stod(cells.at(3)));
      data.y.push_back(std::stod(cells.at(5)));
    }
  }
  return data;
}

DriftProblem drift_problem(unsigned seed, int runs, int passes) {
  base::Random random(seed, 77);
  const auto sign = [&] { return random.uniform() < 0.5 ? -1.0 : 1.0; };
  const int features = random.uniform() < 0.5 ? 1 : 2;
  const double linear = 0.25 * sign();
  const double quadratic = random.uniform(-0.1, 0.1);
  const double cubic = random.uniform(-0.05, 0.05);
  struct Feature {
    double centre, sigma, height;
  };
  std::vector<Feature> shape;
  for (int i = 0; i < features; ++i) {
    const double centre = random.uniform(-20.0, 60.0);
    const double sigma = random.uniform(6.0, 9.0);
    shape.push_back({centre, sigma, 0.1 * sign()});
  }
  if (features == 2 && std::abs(shape[1].centre - shape[0].centre) < 20.0) {
    shape[1].centre = shape[0].centre < 20.0 ? shape[0].centre + 30.0 : shape[0].centre - 30.0;
  }
  DriftProblem problem;
  problem.truth = [=](double temp_c) {
    const double u = (temp_c - 20.0) / 50.0;
    double value = u * (linear + u * (quadratic + u * cubic));
    for (const Feature& f : shape) {
      value += f.height * std::exp(-0.5 * std::pow((temp_c - f.centre) / f.sigma, 2));
    }
    return value;
  };
  for (int run = 0; run < runs; ++run) {
    const double offset = 0.02 * random.gaussian();
    for (int row = 0; row < 21 * passes; ++row) {
      const double temp_c = -30.0 + 5.0 * (row % 21) + 0.3 * random.gaussian();
      problem.data.x.push_back(temp_c);
      problem.data.y.push_back(problem.truth(temp_c) + offset + 0.002 * random.gaussian());
      problem.data.weight.push_back(1.0 / (0.002 * 0.002));
      problem.data.group.push_back(run);
    }
  }
  problem.data.group_variance = 0.02 * 0.02;
  return problem;
}

double worst_shape_error(const DriftProblem& problem, const std::function<double(double)>& f) {
  std::vector<double> error;
  double mean = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    const double temp_c = -30.0 + 0.1 * i;
    error.push_back(f(temp_c) - problem.truth(temp_c));
    mean += error.back() / 1001.0;
  }
  double worst = 0.0;
  for (const double e : error) {
    worst = std::max(worst, std::abs(e - mean));
  }
  return worst;
}

std::function<double(double)> plateau_spline(const TrainingData& data, double first, double spacing, int plateaus) {
  const auto n = static_cast<std::size_t>(plateaus);
  std::map<int, std::pair<double, int>> level;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    level[data.group[i]].first += data.y[i];
    ++level[data.group[i]].second;
  }
  std::vector<double> x(n), y(n), second(n), count(n);
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const auto k = static_cast<std::size_t>(std::clamp(std::lround((data.x[i] - first) / spacing), 0L, plateaus - 1L));
    const auto& [sum, rows] = level[data.group[i]];
    x[k] += data.x[i];
    y[k] += data.y[i] - sum / rows;
    count[k] += 1.0;
  }
  for (std::size_t k = 0; k < n; ++k) {
    x[k] /= count[k];
    y[k] /= count[k];
  }
  std::vector<double> pivot(n, 1.0), right(n);  // Thomas algorithm for the second derivatives
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double below = k > 1 ? x[k] - x[k - 1] : 0.0;
    const double ratio = below / pivot[k - 1];
    pivot[k] = 2.0 * (x[k + 1] - x[k - 1]) - ratio * below;
    right[k] =
        6.0 * ((y[k + 1] - y[k]) / (x[k + 1] - x[k]) - (y[k] - y[k - 1]) / (x[k] - x[k - 1])) - ratio * right[k - 1];
  }
  for (std::size_t k = n - 2; k >= 1; --k) {
    second[k] = (right[k] - (x[k + 1] - x[k]) * second[k + 1]) / pivot[k];
  }
  return [=](double at) {
    std::size_t k = 0;
    while (k + 2 < n && at > x[k + 1]) {
      ++k;
    }
    const double h = x[k + 1] - x[k];
    const double a = (x[k + 1] - at) / h;
    const double b = (at - x[k]) / h;
    return a * y[k] + b * y[k + 1] + ((a * a * a - a) * second[k] + (b * b * b - b) * second[k + 1]) * h * h / 6.0;
  };
}

std::vector<int> folds_by_group(const TrainingData& data, int folds) {
  std::vector<int> fold;
  std::transform(data.group.begin(), data.group.end(), std::back_inserter(fold),
                 [folds](int group) { return group % folds; });
  return fold;
}

}  // namespace soak::anfis::test
