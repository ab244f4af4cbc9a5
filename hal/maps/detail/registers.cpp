// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/registers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace soak::hal {
namespace {

constexpr double kFloatTolerance = 1e-3;
constexpr int kWordBits = 16;

// The float helpers of libmodbus give other byte orders in other versions: words are put together here.
float decode_float(WordOrder order, std::span<const std::uint16_t> words) {
  const bool low_first = order == WordOrder::low_first;
  const std::uint32_t low = words[low_first ? 0 : 1];
  const std::uint32_t high = words[low_first ? 1 : 0];
  return std::bit_cast<float>((high << kWordBits) | low);
}

Words encode_float(WordOrder order, float number) {
  const auto bits = std::bit_cast<std::uint32_t>(number);
  const auto low = static_cast<std::uint16_t>(bits);
  const auto high = static_cast<std::uint16_t>(bits >> kWordBits);
  return order == WordOrder::low_first ? Words{low, high} : Words{high, low};
}

double decode_number(const RegisterPlace& place, std::span<const std::uint16_t> words) {
  switch (place.type) {
    case RegisterType::u16:
      return words[0];
    case RegisterType::i16:
      return std::bit_cast<std::int16_t>(words[0]);
    case RegisterType::f32:
      return decode_float(place.word_order, words);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

template <class T>
bool holds(double number) {
  return number >= std::numeric_limits<T>::lowest() && number <= std::numeric_limits<T>::max();
}

}  // namespace

int word_count(RegisterType type) { return type == RegisterType::f32 ? 2 : 1; }

double decode_value(const RegisterPlace& place, std::span<const std::uint16_t> words, int decimals) {
  const double number = place.scale * decode_number(place, words);
  // A division by a power of ten is exact to the last digit, a multiplication by its inverse is not.
  return number / std::pow(10.0, decimals);
}

base::Result<Words> encode_value(const RegisterPlace& place, double value, int decimals) {
  const double number = value * std::pow(10.0, decimals) / place.scale;
  const double whole = std::round(number);
  switch (place.type) {
    case RegisterType::u16:
      if (holds<std::uint16_t>(whole)) return Words{static_cast<std::uint16_t>(whole)};
      break;
    case RegisterType::i16:
      if (holds<std::int16_t>(whole)) return Words{std::bit_cast<std::uint16_t>(static_cast<std::int16_t>(whole))};
      break;
    case RegisterType::f32:
      if (holds<float>(number)) return encode_float(place.word_order, static_cast<float>(number));
      break;
  }
  return base::bad_input(fmt::format("{} does not fit the register", value));
}

bool same_value(const RegisterPlace& place, std::span<const std::uint16_t> a, std::span<const std::uint16_t> b) {
  if (std::equal(a.begin(), a.end(), b.begin(), b.end())) return true;
  if (place.type != RegisterType::f32) return false;
  const double difference = decode_value(place, a, 0) - decode_value(place, b, 0);
  return std::abs(difference) <= kFloatTolerance;
}

bool says_alarm(const RegisterAlarm& alarm, int content) {
  const auto among = [content](const std::vector<int>& codes) {
    return std::find(codes.begin(), codes.end(), content) != codes.end();
  };
  if (alarm.mask) return (content & *alarm.mask) != 0;
  return alarm.active.empty() ? !among(alarm.inactive) : among(alarm.active);
}

std::string registers_text(int address, int count) {
  return count == 1 ? fmt::format("register {}", address)
                    : fmt::format("registers {} to {}", address, address + count - 1);
}

}  // namespace soak::hal
