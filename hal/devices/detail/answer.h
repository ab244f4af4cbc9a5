// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/maps/text_map.h"

/// Lines of text and the values in them. Errors are of kind `device` without a place.
namespace soak::hal {

/// What stands between the commas of an answer, without blanks around it.
[[nodiscard]] std::vector<std::string> split_answer(std::string_view answer);

/// The field of an answer. Refuses an answer with another number of fields.
[[nodiscard]] base::Result<std::string> field_of(const TextField& from, std::string_view answer);

/// The value in an answer: a finite number, or the number of the code whose word it is.
[[nodiscard]] base::Result<double> decode_answer(const TextQuantity& quantity, std::string_view answer);

/// How a command spells a value: the word of its code, or a number rounded to the quantity's decimals. Refuses
/// (bad_input) a number that stands for no code.
[[nodiscard]] base::Result<std::string> spell(const TextQuantity& quantity, double value);

/// The command that writes the value spelt so.
[[nodiscard]] std::string write_command(const TextQuantity& quantity, std::string_view spelt);

[[nodiscard]] bool begins_with_any(std::string_view answer, const std::vector<std::string>& beginnings);

/// Whether the controller's answer refuses a command.
[[nodiscard]] bool is_refusal(const TextMap& map, std::string_view answer);

}  // namespace soak::hal
