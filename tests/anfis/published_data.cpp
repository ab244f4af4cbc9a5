// SPDX-License-Identifier: Apache-2.0
#include "published_data.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <istream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>

#include "support.h"

namespace soak::anfis::test {
namespace {

/// Second of two columns.
std::vector<double> second_column(std::istream& lines) {
  std::vector<double> column;
  for (double first = 0.0, second = 0.0; lines >> first >> second;) column.push_back(second);
  return column;
}

TrainingData delay_rows(const std::vector<double>& series, std::size_t first, std::size_t count) {
  TrainingData data;
  data.inputs = 4;
  for (std::size_t t = first; t < first + count; ++t) {
    for (const std::size_t delay : {18U, 12U, 6U, 0U}) data.x.push_back(series.at(t - delay));
    data.y.push_back(series.at(t + 6));
  }
  return data;
}

PublishedData delays(const std::vector<double>& series, std::size_t first) {
  return {delay_rows(series, first, 500), delay_rows(series, first + 500, 500)};
}

/// x(0), x(1).. by Runge-Kutta steps of 0.1 whose delayed value stays the same over the step.
std::vector<double> held_delay_series(int seconds) {
  constexpr double kStep = 0.1;
  constexpr std::size_t kDelay = 169;
  std::vector<double> x = {1.2};
  for (std::size_t k = 0; k < 10 * static_cast<std::size_t>(seconds); ++k) {
    const double delayed = k > kDelay ? x[k - kDelay] : 0.0;
    const double birth = 0.2 * delayed / (1.0 + std::pow(delayed, 10));
    const auto slope = [&](double value) { return birth - 0.1 * value; };
    const double k1 = slope(x[k]);
    const double k2 = slope(x[k] + 0.5 * kStep * k1);
    const double k3 = slope(x[k] + 0.5 * kStep * k2);
    const double k4 = slope(x[k] + kStep * k3);
    x.push_back(x[k] + kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4));
  }
  std::vector<double> series;
  for (std::size_t k = 0; k < x.size(); k += 10) series.push_back(x[k]);
  return series;
}

/// Folder of recordings that belong to others.
std::filesystem::path shared_data() {
  const char* folder = std::getenv("SOAK_TEST_DATA");
  if (folder != nullptr && *folder != '\0') return folder;
  return std::filesystem::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared" / "data";
}

TrainingData cube(double first, int points) {
  TrainingData data;
  data.inputs = 3;
  for (int i = 0; i < points * points * points; ++i) {
    const double x = first + i / (points * points);
    const double y = first + i / points % points;
    const double z = first + i % points;
    data.x.insert(data.x.end(), {x, y, z});
    data.y.push_back(std::pow(1.0 + std::sqrt(x) + 1.0 / y + std::pow(z, -1.5), 2));
  }
  return data;
}

}  // namespace

PublishedData mackey_glass() {
  std::string text = read_vector_file("mackey_glass.csv");
  for (char& c : text) c = c == ',' ? ' ' : c;
  std::istringstream lines(text);
  std::string header;
  std::getline(lines, header);
  return delays(second_column(lines), 118);
}

PublishedData demonstration_mackey_glass() { return delays(held_delay_series(1200), 117); }

std::optional<MatlabMackeyGlass> matlab_mackey_glass() {
  const std::filesystem::path folder = shared_data() / "matlab_anfis";
  std::ifstream series(folder / "mgdata.dat");
  std::ifstream outputs(folder / "mgdata_hybrid_offline_check.dat");
  if (!series || !outputs) return std::nullopt;
  MatlabMackeyGlass matlab{delays(second_column(series), 117), second_column(outputs)};
  if (matlab.outputs.size() != 1000) throw std::runtime_error("MATLAB's outputs are not 1000 rows");
  return matlab;
}

PublishedData three_input_function() { return {cube(1.0, 6), cube(1.5, 5)}; }

double average_percentage_error(const TrainingData& data, const Model& model) {
  double sum = 0.0;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    sum += std::abs(data.y[i] - evaluate(model, data.row(i))) / std::abs(data.y[i]);
  }
  return 100.0 * sum / static_cast<double>(data.rows());
}

CertifiedFit nist_linear(const std::string& name) {
  const auto v = nlohmann::json::parse(read_vector_file("nist_strd_linear.json")).at(name);
  const auto vector = [&](const char* key) {
    const auto values = v.at(key).get<std::vector<double>>();
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  CertifiedFit fit{{}, vector("y"), vector("b"), vector("sd")};
  const Eigen::VectorXd x = vector("x");
  fit.a.resize(x.size(), fit.b.size());
  for (Eigen::Index k = 0; k < fit.a.cols(); ++k) fit.a.col(k) = x.array().pow(static_cast<double>(k));
  return fit;
}

double digits(double value, double certified) { return -std::log10(std::abs(value - certified) / std::abs(certified)); }

DenseTruth gyro_truth() {
  std::istringstream lines(read_vector_file("gyro_truth_dense.csv"));
  std::string line;
  std::getline(lines, line);
  DenseTruth truth;
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    truth.temp_c.push_back(std::stod(line.substr(0, comma)));
    truth.drift_degph.push_back(std::stod(line.substr(comma + 1)));
  }
  return truth;
}

ShapeError shape_error(const DenseTruth& truth, const std::function<double(double)>& curve) {
  std::vector<double> error;
  double mean = 0.0;
  const auto count = static_cast<double>(truth.temp_c.size());
  for (std::size_t i = 0; i < truth.temp_c.size(); ++i) {
    error.push_back(curve(truth.temp_c[i]) - truth.drift_degph[i]);
    mean += error.back() / count;
  }
  ShapeError result{0.0, 0.0};
  for (const double e : error) {
    result.rmse += (e - mean) * (e - mean) / count;
    result.worst = std::max(result.worst, std::abs(e - mean));
  }
  result.rmse = std::sqrt(result.rmse);
  return result;
}

}  // namespace soak::anfis::test
