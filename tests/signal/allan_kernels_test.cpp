// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "allan_reference.h"
#include "base/instruction_set.h"
#include "calib/signal/allan/detail/kernels.h"

// A second copy of the kernels under another name, without clones for newer processors and as the tests are compiled.
#undef SOAK_CLONES
#define SOAK_CLONES
#define allan allan_baseline
#include "calib/signal/allan/detail/kernels.cpp"  // NOLINT(bugprone-suspicious-include): the point of this file
#undef allan

namespace soak::calib::signal {
namespace {

// The loader picks the clone for this processor; the copy is for any x86-64 one.
TEST(AllanKernels, GiveTheSameBitsOnEveryInstructionSet) {
  const std::vector<double> x = test::gaussian_noise(20000, 1);
  for (const std::size_t m : {1U, 2U, 7U, 100U, 5001U}) {
    for (const std::size_t starts : {1U, 2U, 7U, 8U, 9U, 15U, 16U, 17U, 519U, 520U, 521U, 1032U, 4096U, 4097U}) {
      EXPECT_EQ(allan::second_differences(x.data(), m, starts),
                allan_baseline::second_differences(x.data(), m, starts));
      EXPECT_EQ(allan::third_differences(x.data(), m, starts), allan_baseline::third_differences(x.data(), m, starts));
      EXPECT_EQ(allan::modified_differences(x.data(), m, starts),
                allan_baseline::modified_differences(x.data(), m, starts));
    }
  }
}

// A vector that ends with the last point they may read: sanitizers see one beyond it.
TEST(AllanKernels, ReadNoPointBeyondTheLastDifference) {
  for (const std::size_t m : {1U, 5U, 300U}) {
    for (const std::size_t starts : {1U, 8U, 9U, 17U, 521U, 4096U}) {
      const std::vector<double> second = test::gaussian_noise(starts + 2 * m, 2);
      const std::vector<double> third = test::gaussian_noise(starts + 3 * m, 3);
      const std::vector<double> windows = test::gaussian_noise(starts + 3 * m - 1, 4);
      EXPECT_GT(allan::second_differences(second.data(), m, starts), 0.0);
      EXPECT_GT(allan::third_differences(third.data(), m, starts), 0.0);
      EXPECT_GT(allan::modified_differences(windows.data(), m, starts), 0.0);
    }
  }
}

// The window sums far along a block of a phase that walks away from 0, against extended precision: the bound of
// kernels.h, to which the phase adds nothing here because its points are taken as they are.
TEST(AllanKernels, WindowSumsKeepTheDigitsThatTheirBoundPromises) {
  std::vector<double> x = {1e6};
  for (const double step : test::gaussian_noise(60000, 5)) x.push_back(x.back() + 1000.0 * step);
  const std::size_t starts = 20000;
  for (const std::size_t m : {1U, 50U, 12000U}) {
    std::vector<long double> sums = {0.0L};
    for (const double point : x) sums.push_back(sums.back() + point);
    long double squares = 0.0L;
    double most = 0.0, reach = 0.0;
    for (std::size_t i = 0; i < starts; ++i) {
      const long double s = sums[i + 3 * m] - 3.0L * sums[i + 2 * m] + 3.0L * sums[i + m] - sums[i];
      squares += s * s;
      most = std::max(most, static_cast<double>(std::abs(s)));
    }
    for (std::size_t i = 0; i + m < starts + 3 * m; ++i) reach = std::max(reach, std::abs(x[i + m] - x[i]));
    const auto md = static_cast<double>(m);
    const double error =
        std::ldexp(1.0, -53) * (starts / 8.0 * (most + 192.0 * reach) + md * (md / 8.0 + 12.0) * reach);
    const auto length = static_cast<double>(std::sqrt(squares));
    // |S + e| - |S| <= |e| <= sqrt(starts) * the largest error; the sum of squares itself is rounded 2500 times.
    EXPECT_NEAR(std::sqrt(allan::modified_differences(x.data(), m, starts)), length,
                std::sqrt(static_cast<double>(starts)) * error + 3e-13 * length)
        << m;
    EXPECT_LT(std::sqrt(static_cast<double>(starts)) * error, 1e-8 * length) << "the bound says nothing";
  }
}

}  // namespace
}  // namespace soak::calib::signal
