// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/streaming_denoiser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/signal/wavelet/denoising.h"
#include "wavelet_support.h"

namespace soak::calib::signal {
namespace {

using Signal = std::vector<double>;

constexpr std::array kAllRules = {Shrinkage::none, Shrinkage::soft, Shrinkage::hard, Shrinkage::garrote};

using test::wavelet;

StreamingDenoiser denoiser(const std::string& name, Shrinkage rule, const Signal& thresholds) {
  auto created = StreamingDenoiser::create(wavelet(name), rule, thresholds);
  if (!created) throw std::runtime_error(created.error().message);
  return std::move(*created);
}

/// White noise on a slow wave, with jumps: details of every size on every level.
Signal lively(std::size_t count, std::uint64_t seed) {
  base::Random random(seed);
  Signal x;
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = static_cast<double>(i);
    x.push_back(random.gaussian() + 3.0 * std::sin(0.01 * t) + (i % 700 < 200 ? 5.0 : 0.0));
  }
  return x;
}

void push(StreamingDenoiser& stream, const Signal& x, std::size_t first, std::size_t last, StreamedSamples& into) {
  const auto pushed = stream.push(std::span(x).subspan(first, last - first), into);
  if (!pushed) throw std::runtime_error(pushed.error().message);
}

/// The whole signal in pushes of `chunk` samples.
StreamedSamples streamed(StreamingDenoiser& stream, const Signal& x, std::size_t chunk) {
  StreamedSamples out;
  for (std::size_t i = 0; i < x.size(); i += chunk) push(stream, x, i, std::min(i + chunk, x.size()), out);
  stream.flush(out);
  return out;
}

/// By denoise(), with the same thresholds as relaxation factors of 1.
Denoised batch(const std::string& name, Shrinkage rule, const Signal& thresholds, const Signal& x) {
  const auto result = denoise(
      x, wavelet(name), {.levels = thresholds.size(), .shrinkage = rule, .relaxation = thresholds, .threshold = 1.0});
  if (!result) throw std::runtime_error(result.error().message);
  return *result;
}

Signal thresholds_for(std::size_t levels) {
  Signal thresholds;
  for (std::size_t j = 0; j < levels; ++j) thresholds.push_back(0.6 + 0.3 * static_cast<double>(j % 4));
  return thresholds;
}

std::vector<std::string> all_wavelets() {
  std::vector<std::string> names;
  for (int n = 1; n <= 10; ++n) names.push_back("db" + std::to_string(n));
  for (int n = 2; n <= 10; ++n) names.push_back("sym" + std::to_string(n));
  return names;
}

TEST(StreamingDenoiser, EqualsTheBatchFromTheFirstSampleToTheLastHoweverTheSignalIsCut) {
  const Signal x = lively(2111, 1);
  constexpr std::size_t kChunks[] = {1, 2, 3, 16, 37, 256, 999, 1000};
  std::size_t turn = 0;
  for (const std::string& name : all_wavelets()) {
    for (std::size_t levels = 1; levels <= 8; ++levels) {
      const Signal thresholds = thresholds_for(levels);
      for (const Shrinkage rule : kAllRules) {
        const Denoised expected = batch(name, rule, thresholds, x);
        StreamingDenoiser stream = denoiser(name, rule, thresholds);
        const StreamedSamples out = streamed(stream, x, kChunks[turn++ % std::size(kChunks)]);
        ASSERT_EQ(out.signal, expected.signal) << name << " " << levels << " " << static_cast<int>(rule);
        ASSERT_EQ(out.trend, expected.trend) << name << " " << levels;
      }
    }
  }
}

TEST(StreamingDenoiser, GivesTheSameBitsForEveryChunkSize) {
  const Signal x = lively(3000, 2);
  StreamingDenoiser stream = denoiser("db8", Shrinkage::garrote, thresholds_for(5));
  const StreamedSamples whole = streamed(stream, x, x.size());
  for (std::size_t chunk = 1; chunk <= 1000; chunk += chunk < 70 ? 1 : 97) {
    const StreamedSamples out = streamed(stream, x, chunk);
    ASSERT_EQ(out.signal, whole.signal) << chunk;
    ASSERT_EQ(out.trend, whole.trend) << chunk;
  }
}

TEST(StreamingDenoiser, EqualsTheBatchForSignalsShorterThanTheFilters) {
  for (const std::string name : {"db1", "db2", "db5", "db10"}) {
    for (std::size_t count = 1; count <= 45; ++count) {
      const Signal x = lively(count, count);
      for (const std::size_t levels : {1U, 2U, 5U}) {
        const Signal thresholds = thresholds_for(levels);
        StreamingDenoiser stream = denoiser(name, Shrinkage::soft, thresholds);
        const StreamedSamples out = streamed(stream, x, 1 + count % 7);
        const Denoised expected = batch(name, Shrinkage::soft, thresholds, x);
        ASSERT_EQ(out.signal, expected.signal) << name << " " << count << " " << levels;
        ASSERT_EQ(out.trend, expected.trend) << name << " " << count << " " << levels;
      }
    }
  }
}

TEST(StreamingDenoiser, HoldsBackLatencySamplesAtMostAndThatManyOnce) {
  for (const std::string name : {"db1", "db3", "db8", "sym10"}) {
    for (const std::size_t levels : {1U, 2U, 4U, 6U}) {
      StreamingDenoiser stream = denoiser(name, Shrinkage::soft, thresholds_for(levels));
      EXPECT_EQ(stream.latency(), ((std::size_t{1} << levels) - 1) * (wavelet(name).length() - 1));
      const Signal x = lively(stream.latency() + 600, 3);
      StreamedSamples out;
      std::size_t most = 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        push(stream, x, i, i + 1, out);
        ASSERT_EQ(out.signal.size(), out.trend.size());
        most = std::max(most, i + 1 - out.signal.size());
      }
      EXPECT_EQ(most, stream.latency()) << name << " " << levels;
    }
  }
}

TEST(StreamingDenoiser, GivesSamplesInGroupsOfTwoToTheLevelsOnceUnderWay) {
  for (const std::string name : {"db1", "db3", "db8"}) {
    StreamingDenoiser stream = denoiser(name, Shrinkage::soft, thresholds_for(4));
    const Signal x = lively(2 * stream.latency() + 512, 8);
    StreamedSamples out;
    std::size_t groups = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t before = out.signal.size();
      push(stream, x, i, i + 1, out);
      const std::size_t group = out.signal.size() - before;
      if (group == 0 || i < 2 * stream.latency()) continue;
      ASSERT_EQ(group, 16U) << name << " " << i;
      ++groups;
    }
    EXPECT_EQ(groups, 32U) << name;
  }
}

TEST(StreamingDenoiser, StartsAnewAfterFlush) {
  StreamingDenoiser stream = denoiser("db4", Shrinkage::hard, thresholds_for(3));
  StreamedSamples nothing;
  stream.flush(nothing);
  EXPECT_TRUE(nothing.signal.empty());
  for (const std::size_t count : {300U, 5U, 1001U}) {
    const Signal x = lively(count, count);
    const StreamedSamples out = streamed(stream, x, 50);
    EXPECT_EQ(out.signal, batch("db4", Shrinkage::hard, thresholds_for(3), x).signal);
  }
}

TEST(StreamingDenoiser, AppendsToWhatIsThere) {
  StreamingDenoiser stream = denoiser("db2", Shrinkage::soft, {1.0});
  StreamedSamples out{{7.0}, {8.0}};
  push(stream, lively(20, 4), 0, 20, out);
  stream.flush(out);
  ASSERT_EQ(out.signal.size(), 21U);
  ASSERT_EQ(out.trend.size(), 21U);
  EXPECT_EQ(out.signal.front(), 7.0);
  EXPECT_EQ(out.trend.front(), 8.0);
}

TEST(StreamingDenoiser, NewThresholdsHoldForSamplesPushedFromThenOn) {
  const Signal x = lively(4000, 5);
  const Signal before = {0.5, 0.5, 0.5, 0.5};
  const Signal after = {3.0, 2.0, 3.0, 4.0};
  const Signal old_way = batch("db6", Shrinkage::soft, before, x).signal;
  const Signal new_way = batch("db6", Shrinkage::soft, after, x).signal;
  for (const std::size_t change : {1U, 160U, 2000U, 2001U, 2011U}) {
    StreamingDenoiser stream = denoiser("db6", Shrinkage::soft, before);
    StreamedSamples out;
    push(stream, x, 0, change, out);
    const std::size_t done = out.signal.size();
    ASSERT_TRUE(stream.set_thresholds(after));
    push(stream, x, change, x.size(), out);
    stream.flush(out);
    for (std::size_t i = 0; i < done; ++i) ASSERT_EQ(out.signal[i], old_way[i]) << change << " " << i;
    for (std::size_t i = change; i < x.size(); ++i) ASSERT_EQ(out.signal[i], new_way[i]) << change << " " << i;
  }
  EXPECT_NE(old_way, new_way);
}

TEST(StreamingDenoiser, RemovesNoiseWithThresholdsOfAnEarlierStretch) {
  base::Random random(6);
  const auto noise = [&](std::size_t count) {
    Signal x(count);
    for (double& v : x) v = 0.2 * random.gaussian();
    return x;
  };
  const auto earlier = denoise(noise(8192), wavelet("db8"), {.levels = 6});
  ASSERT_TRUE(earlier);
  StreamingDenoiser stream = denoiser("db8", Shrinkage::soft, earlier->thresholds);
  const StreamedSamples out = streamed(stream, noise(32768), 10);
  double sum = 0.0;
  for (const double v : out.signal) sum += v * v;
  // The approximations' share, sigma/8, known to 1/sqrt(2 * 32768/64) = 3.1 %: four of these. Details above 4.2 sigma:
  // one in 40,000, and soft leaves little of them.
  EXPECT_NEAR(std::sqrt(sum / 32768.0), 0.2 / 8.0, 0.2 / 8.0 * 0.13);
}

TEST(StreamingDenoiser, RefusesAMissingSampleByItsIndexAndTakesNoneOfThatPush) {
  const Signal x = lively(500, 7);
  StreamingDenoiser stream = denoiser("db3", Shrinkage::soft, thresholds_for(3));
  StreamedSamples out;
  push(stream, x, 0, 100, out);
  for (const double missing : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    const std::size_t known = out.signal.size();
    const auto refused = stream.push(Signal{1.0, 2.0, missing, 4.0}, out);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, base::ErrorKind::bad_input);
    EXPECT_EQ(refused.error().where, "sample 102");
    EXPECT_EQ(out.signal.size(), known);
  }
  push(stream, x, 100, 500, out);
  stream.flush(out);
  EXPECT_EQ(out.signal, batch("db3", Shrinkage::soft, thresholds_for(3), x).signal);
}

TEST(StreamingDenoiser, RefusesThresholdsAndFiltersItCannotUse) {
  const auto refusal = [](const Wavelet& w, const Signal& thresholds) {
    const auto created = StreamingDenoiser::create(w, Shrinkage::soft, thresholds);
    return created ? std::string("taken") : created.error().where;
  };
  const Wavelet good = wavelet("db8");
  EXPECT_EQ(refusal(good, Signal(16, 1.0)), "taken");
  EXPECT_EQ(refusal(good, {}), "thresholds");
  EXPECT_EQ(refusal(good, Signal(17, 1.0)), "thresholds");
  EXPECT_EQ(refusal(good, {1.0, -1.0}), "level 2");
  Wavelet uneven = good;
  uneven.rec_hi.pop_back();
  EXPECT_EQ(refusal(uneven, {1.0}), "wavelet 'db8'");
  EXPECT_NE(refusal(Wavelet{}, {1.0}), "taken");
  StreamingDenoiser stream = denoiser("db8", Shrinkage::soft, {1.0, 1.0});
  EXPECT_EQ(stream.set_thresholds(Signal{1.0}).error().where, "thresholds");
  const auto infinite = stream.set_thresholds(Signal{1.0, std::numeric_limits<double>::infinity()});
  EXPECT_EQ(infinite.error().where, "level 2");
}

}  // namespace
}  // namespace soak::calib::signal
