// SPDX-License-Identifier: Apache-2.0
#include "station/http/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "station/io/text.h"

namespace soak::station {

base::Status only_parameters(const Parameters& parameters, std::initializer_list<std::string_view> known) {
  for (const auto& [name, value] : parameters) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string rest = known.size() == 0 ? "there are none" : fmt::format("known are {}", fmt::join(known, ", "));
    return base::bad_input("there is no such parameter; " + rest, name);
  }
  return {};
}

base::Result<std::optional<std::string>> single(const Parameters& parameters, const std::string& name) {
  const auto [first, last] = parameters.equal_range(name);
  if (first == last) return std::nullopt;
  if (std::next(first) != last) return base::bad_input("the parameter is given more than once", name);
  if (first->second.empty()) return base::bad_input("the parameter is empty", name);
  if (auto plain = check_text_line(first->second, name); !plain) return base::forward_error(plain);
  return first->second;
}

base::Result<std::optional<std::string>> only_parameter(const Parameters& parameters, const std::string& name) {
  if (name.empty()) {
    if (auto none = only_parameters(parameters, {}); !none) return base::forward_error(none);
    return std::nullopt;
  }
  if (auto known = only_parameters(parameters, {name}); !known) return base::forward_error(known);
  return single(parameters, name);
}

base::Result<std::string> required(const Parameters& parameters, const std::string& name, std::string_view what) {
  const auto value = single(parameters, name);
  if (!value) return base::forward_error(value);
  if (!*value) return base::bad_input(fmt::format("the parameter is missing: {}", what), name);
  return **value;
}

}  // namespace soak::station
