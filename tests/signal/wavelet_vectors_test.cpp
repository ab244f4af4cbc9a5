// SPDX-License-Identifier: Apache-2.0
// Against coefficients and reconstructions that PyWavelets made.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "calib/signal/wavelet/wavelet_transform.h"
#include "wavelet_support.h"

namespace soak::calib::signal {
namespace {

using Json = nlohmann::json;
using Values = std::vector<double>;

constexpr double kTolerance = 1e-10;  // asked for by the vectors' purpose; rounding is 1e-14

Boundary boundary_named(const std::string& mode) {
  return mode == "symmetric" ? Boundary::symmetric : Boundary::periodization;
}

/// Second column of wmra_signal.csv.
Values thesis_signal() {
  std::ifstream file(std::string(SOAK_TEST_FOLDER) + "/data/vectors/wmra_signal.csv");
  std::string line;
  std::getline(file, line);
  Values signal;
  while (std::getline(file, line)) signal.push_back(std::stod(line.substr(line.find(',') + 1)));
  return signal;
}

class Wmra : public testing::TestWithParam<const char*> {
 protected:
  Json expected_ = test::vector_json("wmra_db8.json").at(GetParam());
  Values signal_ = thesis_signal();
  Decomposition decomposition_ =
      test::decomposed(signal_, "db8", expected_.at("level").get<std::size_t>(), boundary_named(GetParam()));

  Values expected(const char* key) const { return expected_.at(key).get<Values>(); }
  /// Reconstruction with every detail d replaced by rule(d, universal threshold).
  template <class Rule>
  Values with_details(Rule&& rule) {
    const double threshold = expected_.at("universal_threshold");
    for (Values& details : decomposition_.details) {
      for (double& d : details) d = rule(d, threshold);
    }
    return test::reconstructed(decomposition_, "db8");
  }
};

INSTANTIATE_TEST_SUITE_P(Modes, Wmra, testing::Values("symmetric", "periodization"),
                         [](const auto& each) { return std::string(each.param); });

TEST_P(Wmra, CoefficientsEqualPyWavelets) {
  const auto details = expected_.at("details_coarse_to_fine").get<std::vector<Values>>();
  ASSERT_EQ(details.size(), decomposition_.levels());
  EXPECT_LE(test::greatest_difference(decomposition_.approximation, expected("approx")), kTolerance);
  for (std::size_t l = 0; l < details.size(); ++l) {
    EXPECT_LE(test::greatest_difference(decomposition_.details[l], details[details.size() - 1 - l]), kTolerance) << l;
  }
}

TEST_P(Wmra, TrendEqualsPyWavelets) {
  EXPECT_LE(test::greatest_difference(with_details([](double, double) { return 0.0; }), expected("trend")), kTolerance);
}

TEST_P(Wmra, SoftThresholdedReconstructionEqualsPyWavelets) {
  const Values signal =
      with_details([](double d, double t) { return std::copysign(std::max(std::abs(d) - t, 0.0), d); });
  EXPECT_LE(test::greatest_difference(signal, expected("soft")), kTolerance);
}

TEST_P(Wmra, HardThresholdedReconstructionEqualsPyWavelets) {
  const Values signal = with_details([](double d, double t) { return std::abs(d) > t ? d : 0.0; });
  EXPECT_LE(test::greatest_difference(signal, expected("hard")), kTolerance);
}

// 1 to 33 samples, shorter and longer than the filters, odd and even.
TEST(Decompose, OfShortSignalsEqualsPyWavelets) {
  const Json vectors = test::vector_json("wavelet_small.json");
  const auto signal = vectors.at("signal").get<Values>();
  ASSERT_EQ(vectors.at("cases").size(), 40U);
  for (const Json& each : vectors.at("cases")) {
    const auto samples = each.at("samples").get<std::ptrdiff_t>();
    const auto expected = each.at("coefficients").get<std::vector<Values>>();
    const Decomposition got = test::decomposed({signal.begin(), signal.begin() + samples}, each.at("wavelet"), 3,
                                               boundary_named(each.at("mode")));
    SCOPED_TRACE(each.at("wavelet").dump() + each.at("mode").dump() + std::to_string(samples));
    EXPECT_LE(test::greatest_difference(got.approximation, expected[0]), kTolerance);
    for (std::size_t l = 0; l < 3; ++l) {
      EXPECT_LE(test::greatest_difference(got.details[l], expected[3 - l]), kTolerance) << l;
    }
  }
}

}  // namespace
}  // namespace soak::calib::signal
