// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/wavelet_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "wavelet_support.h"

namespace soak::calib::signal {
namespace {

using Values = std::vector<double>;

constexpr Boundary kBoundaries[] = {Boundary::symmetric, Boundary::periodization};

// One to a few samples, around every filter length, and across the blocks in which the transform works (120 places, 240
// samples) at odd and even lengths.
constexpr std::size_t kLengths[] = {1,  2,  3,  4,   5,   7,   10,  13,  16,  19,  20,  21,
                                    31, 64, 99, 239, 240, 241, 256, 257, 500, 777, 1024};

/// What stands at place i of the signal's continuation, read from one whole period of it.
class Continuation {
 public:
  Continuation(const Values& signal, Boundary boundary) : period_(signal) {
    if (boundary == Boundary::symmetric) period_.insert(period_.end(), signal.rbegin(), signal.rend());
    if (boundary == Boundary::periodization && signal.size() % 2 == 1) period_.push_back(signal.back());
  }
  [[nodiscard]] double at(std::ptrdiff_t i) const {
    const auto n = static_cast<std::ptrdiff_t>(period_.size());
    return period_[static_cast<std::size_t>((i % n + n) % n)];
  }

 private:
  Values period_;
};

/// Second implementation of one level, c[o] = sum over j of filter[j] x[2 o + lead - j].
Values plain_level(const Values& signal, const Values& filter, Boundary boundary) {
  const bool symmetric = boundary == Boundary::symmetric;
  const std::size_t length = filter.size();
  const Continuation x(signal, boundary);
  Values c(symmetric ? (signal.size() + length - 1) / 2 : (signal.size() + 1) / 2);
  for (std::size_t o = 0; o < c.size(); ++o) {
    const auto lead = static_cast<std::ptrdiff_t>(2 * o + (symmetric ? 1 : length / 2));
    for (std::size_t j = 0; j < length; ++j) c[o] += filter[j] * x.at(lead - static_cast<std::ptrdiff_t>(j));
  }
  return c;
}

/// Second implementation of one level back: every coefficient adds its filter to the signal, from 2 o - lead on.
void add_plain_inverse(const Values& coefficients, const Values& filter, Boundary boundary, Values& signal) {
  const bool symmetric = boundary == Boundary::symmetric;
  const auto lead = static_cast<std::ptrdiff_t>(symmetric ? filter.size() - 2 : filter.size() / 2 - 1);
  const auto period = 2 * static_cast<std::ptrdiff_t>(coefficients.size());
  for (std::size_t o = 0; o < coefficients.size(); ++o) {
    for (std::size_t j = 0; j < filter.size(); ++j) {
      std::ptrdiff_t place = static_cast<std::ptrdiff_t>(2 * o + j) - lead;
      if (!symmetric) place = (place % period + period) % period;
      if (place < 0 || place >= static_cast<std::ptrdiff_t>(signal.size())) continue;
      signal[static_cast<std::size_t>(place)] += coefficients[o] * filter[j];
    }
  }
}

class EachTransform : public testing::TestWithParam<std::string> {
 protected:
  template <class Check>
  static void for_all(Check&& check) {
    for (const Boundary boundary : kBoundaries) {
      for (const std::size_t length : kLengths) {
        SCOPED_TRACE(std::to_string(length) + (boundary == Boundary::symmetric ? " symmetric" : " periodization"));
        check(test::gaussian_signal(length, length), boundary);
      }
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Wavelets, EachTransform, testing::ValuesIn(test::wavelet_names()),
                         [](const auto& each) { return each.param; });

// 20 products of a few units, each rounded to 2e-16 of that, per level; a level multiplies amplitudes by sqrt 2 at most
// where the boundary does not repeat, and short signals by a little more.
constexpr double kTransformRounding = 1e-13;

TEST_P(EachTransform, ReconstructsWhatItDecomposed) {
  for_all([](const Values& signal, Boundary boundary) {
    for (const std::size_t levels : {1U, 2U, 5U, 12U}) {
      const Decomposition decomposition = test::decomposed(signal, GetParam(), levels, boundary);
      EXPECT_LE(test::greatest_difference(test::reconstructed(decomposition, GetParam()), signal), kTransformRounding)
          << levels;
    }
  });
}

TEST_P(EachTransform, GivesTheCoefficientsOfThePlainSums) {
  const Wavelet wavelet = *wavelet_named(GetParam());
  for_all([&](const Values& signal, Boundary boundary) {
    const Decomposition got = test::decomposed(signal, GetParam(), 3, boundary);
    Values approximation = signal;
    for (const Values& details : got.details) {
      EXPECT_LE(test::greatest_difference(details, plain_level(approximation, wavelet.dec_hi, boundary)),
                kTransformRounding);
      approximation = plain_level(approximation, wavelet.dec_lo, boundary);
    }
    EXPECT_LE(test::greatest_difference(got.approximation, approximation), kTransformRounding);
  });
}

// Coefficients that no signal has: thresholded ones are such.
TEST_P(EachTransform, ReconstructsAnyCoefficientsAsThePlainSums) {
  const Wavelet wavelet = *wavelet_named(GetParam());
  for_all([&](const Values& signal, Boundary boundary) {
    Decomposition changed = test::decomposed(signal, GetParam(), 2, boundary);
    changed.approximation = test::gaussian_signal(changed.approximation.size(), 1);
    for (Values& details : changed.details) details = test::gaussian_signal(details.size(), details.size());
    Values approximation(changed.details[0].size());
    add_plain_inverse(changed.approximation, wavelet.rec_lo, boundary, approximation);
    add_plain_inverse(changed.details[1], wavelet.rec_hi, boundary, approximation);
    Values expected(signal.size());
    add_plain_inverse(approximation, wavelet.rec_lo, boundary, expected);
    add_plain_inverse(changed.details[0], wavelet.rec_hi, boundary, expected);
    EXPECT_LE(test::greatest_difference(test::reconstructed(changed, GetParam()), expected), kTransformRounding);
  });
}

double energy_of(const Values& values) { return std::inner_product(values.begin(), values.end(), values.begin(), 0.0); }

TEST_P(EachTransform, KeepsTheEnergyUnderPeriodization) {
  for (const std::size_t length : {2U, 16U, 64U, 1024U}) {
    const Values signal = test::gaussian_signal(length, 3);
    const Decomposition d = test::decomposed(signal, GetParam(), 1, Boundary::periodization);
    // The orthogonal transform turns the signal's vector; 20 roundings per coefficient.
    EXPECT_NEAR((energy_of(d.approximation) + energy_of(d.details[0])) / energy_of(signal), 1.0, 20 * 2.2e-16)
        << length;
  }
  const Values signal = test::gaussian_signal(1024, 3);
  const Decomposition deep = test::decomposed(signal, GetParam(), 10, Boundary::periodization);
  double sum = energy_of(deep.approximation);
  for (const Values& details : deep.details) sum += energy_of(details);
  EXPECT_NEAR(sum / energy_of(signal), 1.0, 10 * 20 * 2.2e-16);
}

// N vanishing moments: a polynomial of degree N - 1 leaves no details where the filter does not reach the boundary.
TEST_P(EachTransform, SeesNoDetailsInPolynomials) {
  const std::size_t length = wavelet_named(GetParam())->length();
  const auto degree = static_cast<double>(length / 2 - 1);
  Values signal;
  for (int i = 0; i < 300; ++i) signal.push_back(std::pow(i / 150.0 - 1.0, degree));  // within -1..1
  const Decomposition d = test::decomposed(signal, GetParam(), 2, Boundary::symmetric);
  const std::size_t edge = length;  // details that the boundary reaches at level 2 on each side, at most
  for (const Values& details : d.details) {
    double most = 0.0;
    for (std::size_t o = edge; o + edge < details.size(); ++o) most = std::max(most, std::abs(details[o]));
    EXPECT_LE(most, 1e-14);  // 20 products below 1, and taps rounded to 1e-16
  }
  double at_boundary = 0.0;
  for (std::size_t o = 0; o < edge; ++o) at_boundary = std::max(at_boundary, std::abs(d.details[0][o]));
  // Where the mirror bends the curve there are some; the constant of db1 is not bent.
  EXPECT_EQ(at_boundary > 1e-6, degree > 0.0);
}

TEST(Decompose, UsesItsMemoryAgain) {
  const Wavelet wavelet = *wavelet_named("db8");
  const Values signal = test::gaussian_signal(3001, 1);
  Decomposition d;
  Values scratch;
  Values back(signal.size());
  std::vector<const double*> first;
  for (int turn = 0; turn < 2; ++turn) {
    ASSERT_TRUE(decompose(signal, wavelet, 6, Boundary::symmetric, d));
    ASSERT_TRUE(reconstruct(d, wavelet, scratch, back));
    std::vector<const double*> places = {d.approximation.data(), d.workspace.data(), scratch.data()};
    for (const Values& details : d.details) places.push_back(details.data());
    if (turn == 0) first = places;
    EXPECT_EQ(places, first);
  }
}

TEST(Decompose, OverwritesWhatAnotherSignalLeft) {
  const Wavelet wavelet = *wavelet_named("sym5");
  Decomposition d = test::decomposed(test::gaussian_signal(900, 1), "db9", 7, Boundary::periodization);
  const Values signal = test::gaussian_signal(333, 2);
  ASSERT_TRUE(decompose(signal, wavelet, 4, Boundary::symmetric, d));
  const Decomposition fresh = test::decomposed(signal, "sym5", 4, Boundary::symmetric);
  EXPECT_EQ(d.samples, 333U);
  EXPECT_EQ(d.boundary, Boundary::symmetric);
  EXPECT_EQ(d.approximation, fresh.approximation);
  EXPECT_EQ(d.details, fresh.details);
}

TEST(Decompose, RefusesAnEmptySignal) {
  Decomposition d;
  const base::Status status = decompose({}, *wavelet_named("db2"), 1, Boundary::symmetric, d);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::bad_input);
}

TEST(Decompose, RefusesValuesThatAreNotFiniteAndNamesTheFirst) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (const std::size_t place : {0U, 17U, 98U}) {
      Values signal = test::gaussian_signal(100, 1);
      signal[place] = signal[99] = bad;
      Decomposition d;
      const base::Status status = decompose(signal, *wavelet_named("db2"), 1, Boundary::symmetric, d);
      ASSERT_FALSE(status);
      EXPECT_EQ(status.error().where, "sample " + std::to_string(place));
    }
  }
}

TEST(Decompose, TakesTheLargestFiniteValues) {
  const Values signal = {std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
  Decomposition d;
  EXPECT_TRUE(decompose(signal, *wavelet_named("db1"), 1, Boundary::symmetric, d));
}

TEST(Decompose, RefusesDepthsOutside1To40) {
  const Values signal = test::gaussian_signal(50, 1);
  Decomposition d;
  for (const std::size_t levels : {0U, 41U}) {
    EXPECT_FALSE(decompose(signal, *wavelet_named("db8"), levels, Boundary::symmetric, d)) << levels;
  }
  EXPECT_TRUE(decompose(signal, *wavelet_named("db8"), 40, Boundary::symmetric, d));
}

TEST(Decompose, RefusesFiltersOfOtherLengths) {
  const Wavelet db2 = *wavelet_named("db2");
  Wavelet odd = db2;
  for (Values* filter : {&odd.dec_lo, &odd.dec_hi, &odd.rec_lo, &odd.rec_hi}) filter->pop_back();
  Wavelet uneven = db2;
  uneven.rec_hi.pop_back();
  Wavelet longer = db2;
  for (Values* filter : {&longer.dec_lo, &longer.dec_hi, &longer.rec_lo, &longer.rec_hi}) filter->resize(22);
  Decomposition d;
  for (const Wavelet& wavelet : {odd, uneven, longer, Wavelet{}}) {
    EXPECT_FALSE(decompose(test::gaussian_signal(50, 1), wavelet, 1, Boundary::symmetric, d));
  }
}

class Reconstruct : public testing::Test {
 protected:
  base::Status run(std::size_t samples = 50) {
    Values signal(samples);
    return reconstruct(d_, *wavelet_named("db3"), scratch_, signal);
  }
  Decomposition d_ = test::decomposed(test::gaussian_signal(50, 1), "db3", 2, Boundary::periodization);
  Values scratch_;
};

TEST_F(Reconstruct, TakesWhatDecomposeGave) { EXPECT_TRUE(run()); }

TEST_F(Reconstruct, RefusesASignalOfAnotherLength) {
  for (const std::size_t samples : {0U, 49U, 51U}) EXPECT_FALSE(run(samples)) << samples;
}

TEST_F(Reconstruct, RefusesAMissingDetailAndNamesTheLevel) {
  d_.details[1].pop_back();
  const base::Status status = run();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "level 2");
}

TEST_F(Reconstruct, RefusesTooManyApproximationCoefficients) {
  d_.approximation.push_back(0.0);
  EXPECT_FALSE(run());
}

TEST_F(Reconstruct, RefusesCoefficientsOfTheOtherBoundary) {
  d_.boundary = Boundary::symmetric;
  EXPECT_FALSE(run());
}

TEST_F(Reconstruct, RefusesADecompositionOfNothing) {
  d_ = {};
  EXPECT_FALSE(run(0));
}

// pywt.dwt_max_level of PyWavelets 1.1.1.
TEST(UsefulLevels, EqualPyWavelets) {
  EXPECT_EQ(useful_levels(1024, *wavelet_named("db8")), 6U);
  EXPECT_EQ(useful_levels(1200000, *wavelet_named("db8")), 16U);
  EXPECT_EQ(useful_levels(8, *wavelet_named("db1")), 3U);
  EXPECT_EQ(useful_levels(29, *wavelet_named("db8")), 0U);
  EXPECT_EQ(useful_levels(30, *wavelet_named("db8")), 1U);
  EXPECT_EQ(useful_levels(0, *wavelet_named("db1")), 0U);
}

}  // namespace
}  // namespace soak::calib::signal
