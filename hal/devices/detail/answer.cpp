// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/text.h"

namespace soak::hal {
namespace {

constexpr std::string_view kPlaceholder = "{}";

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
}

tl::unexpected<base::Error> fault(std::string message) {
  return base::fail(base::ErrorKind::device, std::move(message));
}

/// A plus sign before a number means nothing.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '+' && text[1] != '-';
  return plus ? text.substr(1) : text;
}

}  // namespace

std::vector<std::string> split_answer(std::string_view answer) {
  std::vector<std::string> fields;
  for (;;) {
    const std::size_t comma = answer.find(',');
    fields.push_back(trimmed(answer.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    answer.remove_prefix(comma + 1);
  }
}

base::Result<std::string> field_of(const TextField& from, std::string_view answer) {
  std::vector<std::string> fields = split_answer(answer);
  const auto wanted = static_cast<std::size_t>(from.fields.value_or(from.field));
  const bool right = from.fields ? fields.size() == wanted : fields.size() >= wanted;
  if (!right) {
    return fault(fmt::format("'{}' was answered by '{}', which has not {} field{}", from.ask, answer, wanted,
                             wanted == 1 ? "" : "s"));
  }
  return std::move(fields[static_cast<std::size_t>(from.field) - 1]);
}

base::Result<double> decode_answer(const TextQuantity& quantity, std::string_view answer) {
  const auto field = field_of(quantity.from, answer);
  if (!field) return base::forward_error(field);
  if (quantity.words.empty()) {
    const auto number = base::parse_double(without_plus(*field));
    if (!number)
      return fault(fmt::format("'{}' was answered by '{}': '{}' is no number", quantity.from.ask, answer, *field));
    return *number;
  }
  const auto found = std::find_if(quantity.words.begin(), quantity.words.end(),
                                  [&](const auto& word) { return word.second == *field; });
  if (found == quantity.words.end()) {
    return fault(fmt::format("'{}' was answered by '{}': the map has no word '{}'", quantity.from.ask, answer, *field));
  }
  return static_cast<double>(found - quantity.words.begin());
}

base::Result<std::string> spell(const TextQuantity& quantity, double value) {
  if (quantity.words.empty()) return fmt::format("{:.{}f}", value, quantity.decimals);
  const double last = static_cast<double>(quantity.words.size()) - 1.0;
  if (!(value >= 0.0 && value <= last) || value != std::floor(value)) {
    return base::bad_input(fmt::format("{} stands for no code", value));
  }
  return quantity.words[static_cast<std::size_t>(value)].second;
}

std::string write_command(const TextQuantity& quantity, std::string_view spelt) {
  std::string command = quantity.write;
  const std::size_t place = command.find(kPlaceholder);
  return place == std::string::npos ? command : command.replace(place, kPlaceholder.size(), spelt);
}

bool begins_with_any(std::string_view answer, const std::vector<std::string>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](const std::string& beginning) { return answer.starts_with(beginning); });
}

bool is_refusal(const TextMap& map, std::string_view answer) { return begins_with_any(answer, map.refusals); }

}  // namespace soak::hal
