// SPDX-License-Identifier: Apache-2.0
#include "base/random.h"

#include <cmath>
#include <numbers>

namespace soak::base {
namespace {

constexpr std::uint64_t kGoldenGamma = 0x9E3779B97F4A7C15;

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
  return z ^ (z >> 31);
}

double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace

std::uint64_t hashed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  const std::uint64_t key = mix(mix(seed + kGoldenGamma) ^ (stream * 0xD1342543DE82EF95 + kGoldenGamma));
  return mix(key + (index + 1) * kGoldenGamma);
}

double hashed_gaussian(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  // Another seed than that of hashed(): normals and uniforms of one stream stay independent.
  const double u1 = 1.0 - unit_interval(hashed(~seed, stream, 2 * index));
  const double u2 = unit_interval(hashed(~seed, stream, 2 * index + 1));
  return std::sqrt(-2.0 * std::log(u1)) * std::cos(2.0 * std::numbers::pi * u2);
}

double Random::uniform() { return unit_interval(next()); }

}  // namespace soak::base
