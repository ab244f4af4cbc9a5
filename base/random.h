// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace soak::base {

/// A number that depends on its three arguments alone and looks random: the output function of SplitMix64 (Steele, Lea,
/// Flood 2014) applied to a mix of them. The same on every machine, in any order of calls.
[[nodiscard]] std::uint64_t hashed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

/// Standard normal number that depends on its arguments alone (Box-Muller on two hashed uniforms).
[[nodiscard]] double hashed_gaussian(std::uint64_t seed, std::uint64_t stream, std::uint64_t index);

/// Seeded sequence of random numbers: hashed(seed, stream, 0), (.., 1), ...
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : seed_(seed), stream_(stream) {}

  [[nodiscard]] std::uint64_t next() { return hashed(seed_, stream_, index_++); }
  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform();
  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }
  [[nodiscard]] double gaussian() { return hashed_gaussian(seed_, stream_, index_++); }

 private:
  std::uint64_t seed_;
  std::uint64_t stream_;
  std::uint64_t index_ = 0;
};

}  // namespace soak::base
