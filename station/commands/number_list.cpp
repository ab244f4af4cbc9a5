// SPDX-License-Identifier: Apache-2.0
#include "station/commands/number_list.h"

#include <CLI/Error.hpp>
#include <algorithm>

#include "base/text.h"

namespace soak::station::cli {

std::vector<double> parse_number_list(const std::string& option, std::string_view list, double low, double high,
                                      const std::string& must_be) {
  std::vector<double> numbers;
  for (std::size_t first = 0; first <= list.size();) {
    const std::size_t comma = std::min(list.find(',', first), list.size());
    const auto number = base::parse_double(list.substr(first, comma - first));
    if (!number || *number < low || *number > high) throw CLI::ValidationError(option, "must be " + must_be);
    numbers.push_back(*number);
    first = comma + 1;
  }
  return numbers;
}

}  // namespace soak::station::cli
