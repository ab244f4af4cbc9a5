// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal::test {

/// Names of all wavelets, Daubechies' first.
inline std::vector<std::string> wavelet_names() {
  std::vector<std::string> names;
  for (int n = 1; n <= 10; ++n) names.push_back("db" + std::to_string(n));
  for (int n = 2; n <= 10; ++n) names.push_back("sym" + std::to_string(n));
  return names;
}

inline std::vector<double> gaussian_signal(std::size_t samples, std::uint64_t stream) {
  base::Random random(5, stream);
  std::vector<double> signal(samples);
  for (double& x : signal) x = random.gaussian();
  return signal;
}

/// A file of tests/data/vectors.
inline nlohmann::json vector_json(const std::string& name) {
  std::ifstream file(std::string(SOAK_TEST_FOLDER) + "/data/vectors/" + name);
  return nlohmann::json::parse(file);
}

inline double greatest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// A wavelet that exists.
inline Wavelet wavelet(const std::string& name) {
  auto found = wavelet_named(name);
  if (!found) throw std::runtime_error(found.error().message);
  return *found;
}

/// decompose() where nothing is to be refused.
inline Decomposition decomposed(const std::vector<double>& signal, const std::string& name, std::size_t levels,
                                Boundary boundary) {
  Decomposition decomposition;
  const base::Status status = decompose(signal, *wavelet_named(name), levels, boundary, decomposition);
  EXPECT_TRUE(status) << status.error().message;
  return decomposition;
}

inline std::vector<double> reconstructed(const Decomposition& decomposition, const std::string& name) {
  std::vector<double> signal(decomposition.samples);
  std::vector<double> scratch;
  const base::Status status = reconstruct(decomposition, *wavelet_named(name), scratch, signal);
  EXPECT_TRUE(status) << status.error().message;
  return signal;
}

}  // namespace soak::calib::signal::test
