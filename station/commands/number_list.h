// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace soak::station::cli {

/// Numbers from `low` to `high` between commas, not one of them missing; throws CLI::ValidationError that says of
/// `option` what it `must_be`.
std::vector<double> parse_number_list(const std::string& option, std::string_view list, double low, double high,
                                      const std::string& must_be);

}  // namespace soak::station::cli
