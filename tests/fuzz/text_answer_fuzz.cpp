// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "hal/devices/detail/text_codec.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

hal::TextPlace number(int field, std::optional<int> fields) {
  hal::TextPlace place;
  place.from = {"TEMP?", fields, field};
  return place;
}

bool check_number(const hal::TextPlace& place, std::string_view answer) {
  const auto value = hal::decode_answer(place, answer);
  if (!value) {
    require(!value.error().message.empty(), "a refusal says why");
    return false;
  }
  require(std::isfinite(*value), "a value is a number");
  const auto fields = hal::split_answer(answer);
  require(static_cast<int>(fields.size()) >= place.from.field, "the field is there");
  require(!place.from.fields || static_cast<int>(fields.size()) == *place.from.fields, "and so are all others");
  return true;
}

bool check_word(std::string_view answer) {
  hal::TextPlace mode = number(1, 1);
  mode.words = {"STANDBY", "CONSTANT"};
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
  require(hal::begins_with_any(answer, {"NA:"}) == (answer.substr(0, 3) == "NA:"), "a refusal begins as the map says");
  bool accepted = check_word(answer);
  for (const int field : {1, 2, 4}) {
    accepted = check_number(number(field, 4), answer) || accepted;
    accepted = check_number(number(field, {}), answer) || accepted;
  }
  return accepted;
}

}  // namespace soak::fuzz
