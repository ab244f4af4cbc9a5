// SPDX-License-Identifier: Apache-2.0
#include "db/detail/transform.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace soak::db::codec {
namespace {

/// Decimals that are tried: a float32 that needs more of them than this is noise, not text.
template <class Number>
constexpr unsigned kTriedDigits = sizeof(Number) == 4 ? 6 : kMaxDecimalDigits;

/// Whole numbers up to here are exact as float64.
constexpr double kLargestExact = 9007199254740992.0;

template <class Number>
bool same_bits(Number a, Number b) {
  using Word = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
  return std::bit_cast<Word>(a) == std::bit_cast<Word>(b);
}

/// The mantissa with `digits` decimals that gives back every bit of `number`.
template <class Number>
std::optional<std::uint64_t> mantissa_of(Number number, unsigned digits) {
  const double scaled = static_cast<double>(number) * kPowersOfTen[digits];
  if (!(std::fabs(scaled) <= kLargestExact)) return std::nullopt;
  const auto mantissa = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::nearbyint(scaled)));
  if (!same_bits(decimal_value<Number>(mantissa, digits), number)) return std::nullopt;
  return mantissa;
}

}  // namespace

double entropy_bytes(std::span<const std::uint8_t> planes, std::size_t plane_size) {
  double bits = 0.0;
  for (std::size_t begin = 0; plane_size > 0 && begin < planes.size(); begin += plane_size) {
    const auto plane = planes.subspan(begin, std::min(plane_size, planes.size() - begin));
    std::array<std::uint32_t, 256> histogram{};
    for (const std::uint8_t byte : plane) ++histogram[byte];
    for (const std::uint32_t count : histogram) {
      if (count > 0) bits += count * std::log2(static_cast<double>(plane.size()) / count);
    }
  }
  return bits / 8.0;
}

template <class Number>
std::optional<Decimals> decimals_of(std::span<const Number> numbers) {
  Decimals decimals;
  decimals.mantissas.reserve(numbers.size());
  // The digits can only grow: a number that needs more sends the scan back to the start, a dozen times at most.
  for (std::size_t i = 0; i < numbers.size();) {
    const auto mantissa = mantissa_of(numbers[i], decimals.digits);
    if (mantissa) {
      decimals.mantissas.push_back(*mantissa);
      ++i;
      continue;
    }
    do {
      if (++decimals.digits > kTriedDigits<Number>) return std::nullopt;
    } while (!mantissa_of(numbers[i], decimals.digits));
    decimals.mantissas.clear();
    i = 0;
  }
  return decimals;
}

template std::optional<Decimals> decimals_of<float>(std::span<const float>);
template std::optional<Decimals> decimals_of<double>(std::span<const double>);

}  // namespace soak::db::codec
