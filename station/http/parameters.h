// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

/// Parameters of questions. All refusals are bad_input, at the parameter's name.
namespace soak::station {

/// Query parameters; one may be given several times.
using Parameters = std::multimap<std::string, std::string>;

/// Refuses a parameter that is not among `known`.
[[nodiscard]] base::Status only_parameters(const Parameters& parameters, std::initializer_list<std::string_view> known);

/// The value of a parameter that is given at most once: a line of plain text.
[[nodiscard]] base::Result<std::optional<std::string>> single(const Parameters& parameters, const std::string& name);

/// The same where nothing else is given; `name` empty: nothing at all.
[[nodiscard]] base::Result<std::optional<std::string>> only_parameter(const Parameters& parameters,
                                                                      const std::string& name);

/// As single(), refused where it is not given. `what` it is, for the message.
[[nodiscard]] base::Result<std::string> required(const Parameters& parameters, const std::string& name,
                                                 std::string_view what);

}  // namespace soak::station
