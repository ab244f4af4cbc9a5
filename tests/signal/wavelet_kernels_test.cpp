// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/detail/kernels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "wavelet_kernels_baseline.h"
#include "wavelet_support.h"

namespace soak::calib::signal::wavelet {
namespace {

using Values = std::vector<double>;

Polyphase random_bank(std::size_t taps) {
  const Values values = test::gaussian_signal(4 * taps, taps);
  Polyphase bank;
  bank.taps = taps;
  for (std::size_t t = 0; t < taps; ++t) {
    bank.tap[t] = {values[4 * t], values[4 * t + 1], values[4 * t + 2], values[4 * t + 3]};
  }
  return bank;
}

std::vector<std::uint64_t> bits(const Values& values) {
  std::vector<std::uint64_t> all;
  for (const double value : values) all.push_back(std::bit_cast<std::uint64_t>(value));
  return all;
}

/// Both outputs of the bank, one after the other.
template <class Function>
Values outputs(Function&& function, std::size_t count, const Polyphase& bank) {
  const Values first = test::gaussian_signal(count + bank.taps - 1, 1);
  const Values second = test::gaussian_signal(count + bank.taps - 1, 2);
  Values out(2 * count);
  function(count, bank, first.data(), second.data(), out.data(), out.data() + count);
  return out;
}

/// The sums as the header states them.
void plain_bank(std::size_t count, const Polyphase& bank, const double* first_in, const double* second_in,
                double* first_out, double* second_out) {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t t = 0; t < bank.taps; ++t) {
      first_out[i] += bank.tap[t].first_by_first * first_in[i + t];
      first_out[i] += bank.tap[t].first_by_second * second_in[i + t];
      second_out[i] += bank.tap[t].second_by_first * first_in[i + t];
      second_out[i] += bank.tap[t].second_by_second * second_in[i + t];
    }
  }
}

template <class Check>
void for_all_sizes(Check&& check) {
  for (std::size_t taps = 1; taps <= kMaxLength / 2; ++taps) {
    for (const std::size_t count : {1U, 11U, 12U, 13U, 24U, 35U, 120U}) {
      SCOPED_TRACE(std::to_string(taps) + " taps, " + std::to_string(count) + " places");
      check(count, random_bank(taps));
    }
  }
}

// g++ compiles the kernel for AVX2 and for any x86-64; this machine runs the one, the second copy is the other.
TEST(WaveletFilterBank, GivesTheSameBitsOnEachInstructionSet) {
  for_all_sizes([](std::size_t count, const Polyphase& bank) {
    EXPECT_EQ(bits(outputs(filter_bank, count, bank)), bits(outputs(baseline::filter_bank, count, bank)));
  });
}

TEST(WaveletFilterBank, AddsItsTermsInTheOrderStated) {
  for_all_sizes([](std::size_t count, const Polyphase& bank) {
    EXPECT_EQ(bits(outputs(filter_bank, count, bank)), bits(outputs(plain_bank, count, bank)));
  });
}

TEST(WaveletInterleave, UndoesDeinterleave) {
  for (const std::size_t pairs : {1U, 3U, 4U, 9U, 130U}) {
    const Values z = test::gaussian_signal(2 * pairs, pairs);
    Values even(pairs);
    Values odd(pairs);
    deinterleave(pairs, z.data(), even.data(), odd.data());
    EXPECT_EQ(even.back(), z[2 * pairs - 2]);
    EXPECT_EQ(odd.front(), z[1]);
    Values back(2 * pairs);
    interleave(pairs, even.data(), odd.data(), back.data());
    EXPECT_EQ(back, z);
  }
}

TEST(WaveletAllFinite, FindsASingleBadValueAnywhere) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    for (std::size_t place = 0; place < 37; ++place) {
      Values values = test::gaussian_signal(37, 1);
      EXPECT_TRUE(all_finite(values.size(), values.data()));
      values[place] = bad;
      EXPECT_FALSE(all_finite(values.size(), values.data())) << place;
    }
  }
}

}  // namespace
}  // namespace soak::calib::signal::wavelet
