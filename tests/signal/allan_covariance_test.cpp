// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/noise_terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "calib/signal/allan/allan.h"
#include "calib/signal/noise/noise.h"

namespace soak::calib::signal::allan_fit {
namespace {

constexpr double kMarkovTime = 30.0;

constexpr std::size_t index_of(std::size_t k, std::size_t l) { return k * (k + 1) / 2 + l; }

/// Var(sigma^2) = 2 sigma^4/edf at one averaging time for one term alone.
double degrees_of_freedom(Term term, double samples, double m) {
  const PairCounts counts(std::vector<std::size_t>{static_cast<std::size_t>(samples) + 1});
  const double phi = allan_variances(m, kMarkovTime)[term];
  return 2.0 * phi * phi / covariance_terms(counts, m, m, kMarkovTime)[index_of(term, term)];
}

/// The sum over all lags as it is defined.
TermPairs plain_sum(const PairCounts& counts, double m_a, double m_b) {
  TermPairs sum{};
  const double scale = 2.0 / (4.0 * m_a * m_a * m_b * m_b * counts.differences(m_a) * counts.differences(m_b));
  for (double u = -counts.longest(); u <= counts.longest(); ++u) {
    PerTerm c = difference_covariances(m_a, m_b, u, kMarkovTime);
    c[quantization] = quantization_comb(m_a, m_b, u);
    for (std::size_t k = 0; k < kTerms; ++k) {
      for (std::size_t l = 0; l <= k; ++l) {
        sum[index_of(k, l)] += scale * (k == l ? 1.0 : 2.0) * counts.pairs(m_a, m_b, u) * c[k] * c[l];
      }
    }
  }
  sum[index_of(ramp, ramp)] = 0.0;
  return sum;
}

TEST(AllanCovariance, SecondDifferencesHaveTheAllanVarianceOfTheirTerm) {
  for (const double m : {1.0, 2.0, 7.0, 100.0, 3000.0}) {
    PerTerm c = difference_covariances(m, m, 0.0, kMarkovTime);
    c[quantization] = quantization_comb(m, m, 0.0);
    const PerTerm phi = allan_variances(m, kMarkovTime);
    // sigma^2 = <z^2>/(2 m^2); the Markov term loses (T/m)^2 or (m/T)^2 of the 16 digits.
    for (std::size_t k = 0; k < kTerms; ++k) EXPECT_NEAR(c[k] / (2.0 * m * m) / phi[k], 1.0, 1e-9) << k << " " << m;
  }
}

TEST(AllanCovariance, TheSumByPanelsIsTheSumOverAllLags) {
  const PairCounts counts(std::vector<std::size_t>{3000, 1500});
  for (const double m_a : {1.0, 3.0, 20.0, 100.0, 700.0}) {
    for (const double m_b : {1.0, 4.0, 25.0, 100.0, 170.0, 900.0}) {
      if (m_a > m_b) continue;
      const TermPairs plain = plain_sum(counts, m_a, m_b);
      const TermPairs panels = covariance_terms(counts, m_a, m_b, kMarkovTime);
      const TermPairs a = plain_sum(counts, m_a, m_a);
      const TermPairs b = plain_sum(counts, m_b, m_b);
      for (std::size_t k = 0; k < kTerms; ++k) {
        for (std::size_t l = 0; l <= k; ++l) {
          // Against the largest value that it could have, sqrt(Var_a Var_b) of either term; the header promises 0.1 %.
          const auto size = [&](std::size_t t) {
            if (t == ramp) return 0.5 * m_a * m_b;
            return std::pow(a[index_of(t, t)] * b[index_of(t, t)], 0.25);
          };
          EXPECT_NEAR(panels[index_of(k, l)], plain[index_of(k, l)], 1e-3 * size(k) * size(l))
              << k << l << " at " << m_a << ", " << m_b;
        }
      }
    }
  }
}

TEST(AllanCovariance, WhiteNoiseHasThePublishedDegreesOfFreedom) {
  // The simple formula of NIST SP 1065 for white FM, N phase points: an approximation, here within 6 %.
  constexpr double kPhasePoints = 1025.0;
  for (const double m : {1.0, 2.0, 8.0, 32.0, 128.0}) {
    const double published = (3.0 * (kPhasePoints - 1.0) / (2.0 * m) - 2.0 * (kPhasePoints - 2.0) / kPhasePoints) *
                             (4.0 * m * m) / (4.0 * m * m + 5.0);
    EXPECT_NEAR(degrees_of_freedom(white, kPhasePoints - 1.0, m) / published, 1.0, 0.06) << m;
  }
}

TEST(AllanCovariance, FlickerAndRandomWalkHaveAboutThePublishedDegreesOfFreedom) {
  // The simple formulas of NIST SP 1065 for flicker and random walk FM at m > 1: coarser approximations.
  constexpr double n = 1025.0;
  for (const double m : {4.0, 16.0, 64.0}) {
    const double published_flicker = 5.0 * n * n / (4.0 * m * (n + 3.0 * m));
    const double published_walk =
        (n - 2.0) / m * (std::pow(n - 1.0, 2) - 3.0 * m * (n - 1.0) + 4.0 * m * m) / std::pow(n - 3.0, 2);
    EXPECT_NEAR(degrees_of_freedom(flicker, n - 1.0, m) / published_flicker, 1.0, 0.15) << m;
    EXPECT_NEAR(degrees_of_freedom(allan_fit::random_walk, n - 1.0, m) / published_walk, 1.0, 0.15) << m;
  }
}

/// Sample covariance of the Allan variances at two averaging times over many records.
struct Sampled {
  std::vector<double> mean = {0.0, 0.0, 0.0, 0.0};
  std::vector<std::vector<double>> product = std::vector<std::vector<double>>(4, std::vector<double>(4, 0.0));
};

constexpr int kRecords = 3000;
const std::vector<std::size_t> kMultiples = {1, 4, 12, 50};

template <class MakeNoise>
Sampled sampled(const MakeNoise& noise) {
  Sampled sums;
  for (int r = 0; r < kRecords; ++r) {
    const auto record = PhaseRecord::from_rate(noise({.rate_hz = 1.0, .seed = static_cast<std::uint64_t>(r)}), 1.0);
    const std::vector<AllanPoint> points = allan_points(*record, AllanKind::overlapping, kMultiples);
    for (std::size_t a = 0; a < 4; ++a) {
      const double s = points[a].deviation * points[a].deviation;
      sums.mean[a] += s / kRecords;
      for (std::size_t b = 0; b < 4; ++b) {
        sums.product[a][b] += s * points[b].deviation * points[b].deviation / kRecords;
      }
    }
  }
  return sums;
}

void expect_agreement(const Sampled& sampled, const PerTerm& theta) {
  const CovarianceTable table(PairCounts(std::vector<std::size_t>{301}), {1.0, 4.0, 12.0, 50.0}, 0.0);
  const Eigen::MatrixXd covariance = table.covariance(theta);
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      const auto i = static_cast<Eigen::Index>(a);
      const auto j = static_cast<Eigen::Index>(b);
      const double size = std::sqrt(covariance(i, i) * covariance(j, j));
      const double found = sampled.product[a][b] - sampled.mean[a] * sampled.mean[b];
      // A sample covariance of normal variables scatters by at most sqrt(2/3000) = 2.6 % of `size`; these are closer to
      // chi-squared with edf >= 3 (kurtosis excess 12/edf = 4), sqrt(6/3000) = 4.5 %; three times that.
      EXPECT_NEAR(found / size, covariance(i, j) / size, 0.135) << kMultiples[a] << ", " << kMultiples[b];
    }
  }
}

TEST(AllanCovariance, SimulatedWhiteNoiseScattersAsComputed) {
  PerTerm theta{};
  theta[white] = 1.0;
  expect_agreement(sampled([](const NoiseSource& source) { return white_noise(300, 1.0, source); }), theta);
}

TEST(AllanCovariance, SimulatedFlickerNoiseScattersAsComputed) {
  PerTerm theta{};
  theta[flicker] = 1.0;
  expect_agreement(sampled([](const NoiseSource& source) { return flicker_noise(300, 1.0, source); }), theta);
}

TEST(AllanCovariance, SimulatedWhiteNoiseWithRandomWalkAndRampScattersAsComputed) {
  PerTerm theta{};
  theta[white] = 1.0;
  theta[allan_fit::random_walk] = 0.15 * 0.15;
  theta[ramp] = 0.01 * 0.01;
  expect_agreement(sampled([](const NoiseSource& source) {
                     std::vector<double> rate = white_noise(300, 1.0, source);
                     const std::vector<double> walk = signal::random_walk(300, 0.15, source);
                     const std::vector<double> drift = rate_ramp(300, 0.01, 1.0);
                     for (std::size_t i = 0; i < rate.size(); ++i) rate[i] += walk[i] + drift[i];
                     return rate;
                   }),
                   theta);
}

TEST(AllanCovariance, TwoStretchesKnowTwiceAsMuchAsOne) {
  const TermPairs one = covariance_terms(PairCounts(std::vector<std::size_t>{1001}), 5.0, 40.0, 0.0);
  const TermPairs two = covariance_terms(PairCounts(std::vector<std::size_t>{1001, 1001}), 5.0, 40.0, 0.0);
  EXPECT_NEAR(two[index_of(white, white)] / one[index_of(white, white)], 0.5, 1e-12);
  EXPECT_NEAR(two[index_of(flicker, flicker)] / one[index_of(flicker, flicker)], 0.5, 1e-12);
}

}  // namespace
}  // namespace soak::calib::signal::allan_fit
