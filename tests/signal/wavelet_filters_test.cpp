// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "calib/signal/wavelet/wavelet_transform.h"
#include "wavelet_support.h"

namespace soak::calib::signal {
namespace {

class EachWavelet : public testing::TestWithParam<std::string> {
 protected:
  Wavelet wavelet_ = *wavelet_named(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Wavelets, EachWavelet, testing::ValuesIn(test::wavelet_names()),
                         [](const auto& each) { return each.param; });

/// sum over k of a[k] b[k + shift]
double shifted_product(const std::vector<double>& a, const std::vector<double>& b, std::size_t shift) {
  double sum = 0.0;
  for (std::size_t k = 0; k + shift < a.size(); ++k) sum += a[k] * b[k + shift];
  return sum;
}

// Up to 20 taps below 1, each rounded to 1.1e-16 at most, as are their products and sums.
constexpr double kRounding = 20 * 4 * 1.1e-16;

TEST_P(EachWavelet, IsOrthonormalUnderShiftsByTwo) {
  for (std::size_t shift = 0; shift < wavelet_.length(); shift += 2) {
    const double same = shift == 0 ? 1.0 : 0.0;
    EXPECT_NEAR(shifted_product(wavelet_.rec_lo, wavelet_.rec_lo, shift), same, kRounding);
    EXPECT_NEAR(shifted_product(wavelet_.rec_hi, wavelet_.rec_hi, shift), same, kRounding);
    EXPECT_NEAR(shifted_product(wavelet_.rec_lo, wavelet_.rec_hi, shift), 0.0, kRounding);
    EXPECT_NEAR(shifted_product(wavelet_.rec_hi, wavelet_.rec_lo, shift), 0.0, kRounding);
  }
}

TEST_P(EachWavelet, HasTwoTapsPerVanishingMoment) {
  const std::size_t order = wavelet_.length() / 2;
  EXPECT_EQ(wavelet_.name, GetParam());
  EXPECT_EQ(std::to_string(order), GetParam().substr(GetParam().find_first_of("0123456789")));
  for (std::size_t power = 0; power < order; ++power) {
    // Moments about the middle of the filter; each tap is known to half a unit in its last place, 1.1e-16 of 1 at most.
    double moment = 0.0;
    double scale = 0.0;
    for (std::size_t k = 0; k < wavelet_.length(); ++k) {
      const double term = std::pow(static_cast<double>(k) - static_cast<double>(order), static_cast<double>(power));
      moment += term * wavelet_.dec_hi[k];
      scale += std::abs(term);
    }
    EXPECT_NEAR(moment, 0.0, 4 * 1.1e-16 * scale) << "moment " << power;
  }
}

TEST_P(EachWavelet, HasFiltersThatMirrorEachOtherAsInPyWavelets) {
  const std::size_t length = wavelet_.length();
  double sum = 0.0;
  for (std::size_t k = 0; k < length; ++k) {
    EXPECT_EQ(wavelet_.dec_lo[k], wavelet_.rec_lo[length - 1 - k]);
    EXPECT_EQ(wavelet_.dec_hi[k], wavelet_.rec_hi[length - 1 - k]);
    EXPECT_EQ(wavelet_.dec_hi[k], (k % 2 == 0 ? -1.0 : 1.0) * wavelet_.rec_lo[k]);
    sum += wavelet_.rec_lo[k];
  }
  EXPECT_NEAR(sum, std::sqrt(2.0), kRounding);
}

TEST_P(EachWavelet, EqualsPyWavelets) {
  const auto published = test::vector_json("wavelet_small.json").at("dec_lo").at(GetParam()).get<std::vector<double>>();
  // PyWavelets states the lower symlets to 11 or 12 digits only.
  const double tolerance = GetParam().starts_with("sym") ? 5e-12 : 1e-16;
  EXPECT_LE(test::greatest_difference(wavelet_.dec_lo, published), tolerance);
}

// Daubechies 1992, (6.2.5): h = ((1 + r) , (3 + r), (3 - r), (1 - r)) / (4 sqrt 2) with r = sqrt 3.
TEST(WaveletNamed, HasTheClosedFormOfFourTaps) {
  const double r = std::sqrt(3.0);
  for (const char* name : {"db2", "sym2"}) {
    const Wavelet wavelet = *wavelet_named(name);
    for (std::size_t k = 0; k < 4; ++k) {
      const double h = std::vector<double>{1.0 + r, 3.0 + r, 3.0 - r, 1.0 - r}[k] / (4.0 * std::sqrt(2.0));
      EXPECT_NEAR(wavelet.rec_lo[k], h, 4e-16);
    }
  }
}

/// Greatest less smallest group delay Re(sum k h_k z^k / sum h_k z^k), z = exp(-i w), in the pass band: 0 if symmetric.
double delay_spread(const Wavelet& wavelet) {
  double least = 1e9;
  double most = -1e9;
  for (double w = 0.0; w < 1.57; w += 0.01) {
    std::complex<double> h = 0.0;
    std::complex<double> slope = 0.0;
    for (std::size_t k = 0; k < wavelet.length(); ++k) {
      const auto place = static_cast<double>(k);
      h += wavelet.rec_lo[k] * std::polar(1.0, -w * place);
      slope += place * wavelet.rec_lo[k] * std::polar(1.0, -w * place);
    }
    least = std::min(least, (slope / h).real());
    most = std::max(most, (slope / h).real());
  }
  return most - least;
}

TEST(WaveletNamed, GivesSymletsWhoseDelayVariesLessThanThatOfDaubechiesFilters) {
  for (int n = 4; n <= 10; ++n) {
    const std::string order = std::to_string(n);
    EXPECT_LT(delay_spread(*wavelet_named("sym" + order)), delay_spread(*wavelet_named("db" + order))) << order;
  }
}

TEST(WaveletNamed, RefusesOtherNames) {
  for (const char* name : {"", "db0", "db11", "sym1", "DB8", "db8 ", "haar"}) {
    const auto wavelet = wavelet_named(name);
    ASSERT_FALSE(wavelet) << name;
    EXPECT_EQ(wavelet.error().kind, base::ErrorKind::bad_input);
  }
}

}  // namespace
}  // namespace soak::calib::signal
