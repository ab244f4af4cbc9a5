// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"

/// Lines of text and the values in them. Errors are of kind `device` without a place.
namespace soak::hal {

/// What stands between the separators of an answer, without blanks around it. Blanks as separators: any number of them
/// counts as one.
[[nodiscard]] std::vector<std::string> split_answer(std::string_view answer, std::string_view separator = ",");

/// The field of an answer, or its one character. Refuses an answer with another number of fields, or of another length.
[[nodiscard]] base::Result<std::string> field_of(const TextField& from, std::string_view answer);

/// The value in an answer: a finite number, or the number of the word.
[[nodiscard]] base::Result<double> decode_answer(const TextPlace& place, std::string_view answer);

/// How a command spells a value: the word of that number, or a number rounded to the place's decimals. Refuses
/// (bad_input) a number that stands for no word.
[[nodiscard]] base::Result<std::string> spell(const TextPlace& place, double value);

/// The command that writes the value spelt so.
[[nodiscard]] std::string write_command(const TextPlace& place, std::string_view spelt);

/// Whether an answer begins with one of these, as with one of a map's refusals.
[[nodiscard]] bool begins_with_any(std::string_view answer, const std::vector<std::string>& beginnings);

}  // namespace soak::hal
