// SPDX-License-Identifier: Apache-2.0
#include "station/http/members.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>

#include "station/io/text.h"

namespace soak::station {
namespace {

constexpr std::size_t kLongestLine = 200;

}  // namespace

base::Status only_members(const nlohmann::json& body, std::initializer_list<std::string_view> known) {
  for (const auto& member : body.items()) {
    if (std::find(known.begin(), known.end(), member.key()) != known.end()) continue;
    return base::bad_input("the command has no such member", member.key());
  }
  return {};
}

base::Status check_single_line(const std::string& value, const std::string& name) {
  if (value.size() > kLongestLine) {
    return base::bad_input("longer than " + std::to_string(kLongestLine) + " bytes", name);
  }
  if (value.empty()) return {};
  return check_text_line(value, name);
}

base::Result<std::string> text_member(const nlohmann::json& body, const std::string& name,
                                      const std::optional<std::string>& otherwise) {
  const auto member = body.find(name);
  if (member == body.end() && otherwise) return *otherwise;
  if (member == body.end()) return base::bad_input("the member is missing", name);
  if (!member->is_string()) return base::bad_input("the member is not text", name);
  auto value = member->get<std::string>();
  if (value.empty() && !otherwise) return base::bad_input("the member is empty", name);
  return value;
}

base::Result<std::string> line_member(const nlohmann::json& body, const std::string& name,
                                      const std::optional<std::string>& otherwise) {
  auto value = text_member(body, name, otherwise);
  if (!value) return value;
  if (auto fits = check_single_line(*value, name); !fits) return base::forward_error(fits);
  return value;
}

base::Result<std::string> carried_member(const nlohmann::json& body, const std::string& name) {
  auto value = text_member(body, name, std::nullopt);
  if (!value) return value;
  if (auto plain = check_carried_line(*value, name); !plain) return base::forward_error(plain);
  return value;
}

base::Result<std::optional<double>> number_member(const nlohmann::json& body, const std::string& name) {
  const auto member = body.find(name);
  if (member == body.end() || member->is_null()) return std::nullopt;
  if (!member->is_number()) return base::bad_input("the member is not a number", name);
  return member->get<double>();
}

base::Result<std::optional<std::vector<double>>> numbers_member(const nlohmann::json& body, const std::string& name) {
  const auto member = body.find(name);
  if (member == body.end() || member->is_null()) return std::nullopt;
  const bool fits = member->is_array() && std::ranges::all_of(*member, [](const auto& one) { return one.is_number(); });
  if (!fits) return base::bad_input("the member is not a list of numbers", name);
  return member->get<std::vector<double>>();
}

base::Result<std::optional<std::int32_t>> count_member(const nlohmann::json& body, const std::string& name) {
  const auto member = body.find(name);
  if (member == body.end() || member->is_null()) return std::nullopt;
  if (!member->is_number_integer() || *member < 0 || *member > std::numeric_limits<std::int32_t>::max()) {
    return base::bad_input("the member is not a whole number from 0 on", name);
  }
  return member->get<std::int32_t>();
}

}  // namespace soak::station
