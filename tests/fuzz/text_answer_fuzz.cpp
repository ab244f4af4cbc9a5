// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "hal/devices/detail/answer.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

hal::TextQuantity number(int field, std::optional<int> fields) {
  hal::TextQuantity quantity;
  quantity.from = {"TEMP?", fields, field};
  return quantity;
}

bool check_number(const hal::TextQuantity& quantity, std::string_view answer) {
  const auto value = hal::decode_answer(quantity, answer);
  if (!value) {
    require(!value.error().message.empty(), "a refusal says why");
    return false;
  }
  require(std::isfinite(*value), "a value is a number");
  const auto fields = hal::split_answer(answer);
  require(static_cast<int>(fields.size()) >= quantity.from.field, "the field is there");
  require(!quantity.from.fields || static_cast<int>(fields.size()) == *quantity.from.fields, "and so are all others");
  return true;
}

bool check_word(std::string_view answer) {
  hal::TextQuantity mode = number(1, 1);
  mode.words = {{"off", "STANDBY"}, {"auto", "CONSTANT"}};
  const auto code = hal::decode_answer(mode, answer);
  if (!code) return false;
  const auto word = hal::spell(mode, *code);
  require(word && answer.find(*word) != std::string_view::npos, "a code is spelt as it was answered");
  return true;
}

}  // namespace

bool text_answer(Input input) {
  const std::string_view answer = as_text(input);
  const auto fields = hal::split_answer(answer);
  require(static_cast<std::ptrdiff_t>(fields.size()) == std::count(answer.begin(), answer.end(), ',') + 1,
          "commas part the fields");
  hal::TextMap map;
  map.refusals = {"NA:"};
  require(hal::is_refusal(map, answer) == (answer.substr(0, 3) == "NA:"), "a refusal begins as the map says");
  bool accepted = check_word(answer);
  for (const int field : {1, 2, 4}) {
    accepted = check_number(number(field, 4), answer) || accepted;
    accepted = check_number(number(field, {}), answer) || accepted;
  }
  return accepted;
}

}  // namespace soak::fuzz
