// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

/// Members of the bodies of commands. All refusals are bad_input, at the member's name.
namespace soak::station {

/// Refuses a member that is not among `known`.
[[nodiscard]] base::Status only_members(const nlohmann::json& body, std::initializer_list<std::string_view> known);

/// Refuses a text that is longer than 200 bytes or, unless it is empty, no single line of plain text.
[[nodiscard]] base::Status check_single_line(const std::string& value, const std::string& name);

/// A text member; `otherwise` where it is absent, refused if that is nothing.
[[nodiscard]] base::Result<std::string> text_member(const nlohmann::json& body, const std::string& name,
                                                    const std::optional<std::string>& otherwise);

/// A text that stands in one line: of logs, of tables, of file names.
[[nodiscard]] base::Result<std::string> line_member(const nlohmann::json& body, const std::string& name,
                                                    const std::optional<std::string>& otherwise);

/// What a person has to enter; it ends up in files and certificates, so it must be short and plain.
[[nodiscard]] base::Result<std::string> carried_member(const nlohmann::json& body, const std::string& name);

/// A number; nothing where the member is absent or null.
[[nodiscard]] base::Result<std::optional<double>> number_member(const nlohmann::json& body, const std::string& name);

/// A list of numbers; nothing where the member is absent or null.
[[nodiscard]] base::Result<std::optional<std::vector<double>>> numbers_member(const nlohmann::json& body,
                                                                              const std::string& name);

/// A whole number from 0 on; nothing where the member is absent or null.
[[nodiscard]] base::Result<std::optional<std::int32_t>> count_member(const nlohmann::json& body,
                                                                     const std::string& name);

}  // namespace soak::station
