// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/bytes.h"

/// Reversible maps from the numbers of a chunk to numbers that compress better. All arithmetic is modulo 2^bits of the
/// unsigned word, so every bit pattern survives, those of floats included.
namespace soak::db::codec {

enum class Transform : std::uint8_t {
  plain,   ///< the words themselves
  rotate,  ///< one bit to the left: the exponent of a float32 fills one byte, its sign joins the mantissa
  offset,  ///< minus the least of them: noise about a level becomes small numbers
  delta,   ///< difference to the word before, zigzag coded
  delta2,  ///< difference of differences, zigzag coded: even steps become zeros
};

inline constexpr std::array<Transform, 5> kTransforms = {Transform::plain, Transform::rotate, Transform::offset,
                                                         Transform::delta, Transform::delta2};

constexpr std::string_view name_of(Transform transform) {
  constexpr std::array<std::string_view, 5> kNames = {"", "rotate+", "offset+", "delta+", "delta2+"};
  return kNames[static_cast<std::size_t>(transform)];
}

/// 0, -1, 1, -2, ... to 0, 1, 2, 3, ...: small differences of either sign leave the upper bytes zero.
template <class Word>
constexpr Word zigzag(Word word) {
  const auto sign = static_cast<Word>((word >> (std::numeric_limits<Word>::digits - 1)) != 0 ? ~Word{0} : Word{0});
  return static_cast<Word>(static_cast<Word>(word << 1) ^ sign);
}

template <class Word>
constexpr Word unzigzag(Word word) {
  const auto sign = static_cast<Word>((word & 1) != 0 ? ~Word{0} : Word{0});
  return static_cast<Word>(static_cast<Word>(word >> 1) ^ sign);
}

/// Replaces each word by its zigzag difference to the one before (to 0 at the start).
template <class Word>
void difference(std::span<Word> words) {
  Word previous = 0;
  for (Word& word : words) {
    const Word current = word;
    word = zigzag(static_cast<Word>(current - previous));
    previous = current;
  }
}

/// Undoes difference().
template <class Word>
void accumulate(std::span<Word> words) {
  Word sum = 0;
  for (Word& word : words) {
    sum = static_cast<Word>(sum + unzigzag(word));
    word = sum;
  }
}

/// Applies `transform` in place; `reference` is what Transform::offset subtracts.
template <class Word>
void apply(Transform transform, std::span<Word> words, Word reference) {
  static_assert(std::is_unsigned_v<Word>);
  if (transform == Transform::rotate) {
    for (Word& word : words) word = std::rotl(word, 1);
  }
  if (transform == Transform::offset) {
    for (Word& word : words) word = static_cast<Word>(word - reference);
  }
  if (transform == Transform::delta || transform == Transform::delta2) difference(words);
  if (transform == Transform::delta2) difference(words);
}

/// Undoes apply().
template <class Word>
void undo(Transform transform, std::span<Word> words, Word reference) {
  if (transform == Transform::delta2) accumulate(words);
  if (transform == Transform::delta || transform == Transform::delta2) accumulate(words);
  if (transform == Transform::offset) {
    for (Word& word : words) word = static_cast<Word>(word + reference);
  }
  if (transform == Transform::rotate) {
    for (Word& word : words) word = std::rotr(word, 1);
  }
}

/// Byte shuffle: first the lowest byte of every word, then the next one of every word, ...
template <class Word>
base::Bytes shuffled(std::span<const Word> words) {
  base::Bytes planes(words.size() * sizeof(Word));
  for (std::size_t byte = 0; byte < sizeof(Word); ++byte) {
    std::uint8_t* plane = planes.data() + byte * words.size();
    for (std::size_t i = 0; i < words.size(); ++i) plane[i] = static_cast<std::uint8_t>(words[i] >> (8 * byte));
  }
  return planes;
}

/// Undoes shuffled(); `planes` holds words.size() · sizeof(Word) bytes.
template <class Word>
void unshuffle(std::span<const std::uint8_t> planes, std::span<Word> words) {
  const std::size_t count = words.size();
  const std::uint8_t* lowest = planes.data();
  for (std::size_t i = 0; i < count; ++i) {
    Word word = 0;
    for (std::size_t byte = 0; byte < sizeof(Word); ++byte) {
      word = static_cast<Word>(word | static_cast<Word>(static_cast<Word>(lowest[byte * count + i]) << (8 * byte)));
    }
    words[i] = word;
  }
}

/// Bytes that an ideal order-0 coder with one table per plane of `plane_size` bytes would need.
[[nodiscard]] double entropy_bytes(std::span<const std::uint8_t> planes, std::size_t plane_size);

/// Numbers that are short decimals: value = mantissa / 10^digits, exactly, in the arithmetic of the type (float32 from
/// the float64 quotient).
struct Decimals {
  unsigned digits = 0;
  std::vector<std::uint64_t> mantissas;  ///< two's complement
};

inline constexpr unsigned kMaxDecimalDigits = 12;

/// The decimals that give back every bit of `numbers`; nothing where some number is no short decimal (-0.0, NaN and
/// infinity are none). After Afroozeh, Kuffo, Boncz: ALP, SIGMOD 2023, without its exceptions.
template <class Number>
[[nodiscard]] std::optional<Decimals> decimals_of(std::span<const Number> numbers);

inline constexpr std::array<double, kMaxDecimalDigits + 1> kPowersOfTen = {1e0, 1e1, 1e2, 1e3,  1e4,  1e5, 1e6,
                                                                           1e7, 1e8, 1e9, 1e10, 1e11, 1e12};

/// The number that a mantissa stands for; `digits` is at most kMaxDecimalDigits.
template <class Number>
[[nodiscard]] Number decimal_value(std::uint64_t mantissa, unsigned digits) {
  return static_cast<Number>(static_cast<double>(static_cast<std::int64_t>(mantissa)) / kPowersOfTen[digits]);
}

}  // namespace soak::db::codec
