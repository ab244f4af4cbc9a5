// SPDX-License-Identifier: Apache-2.0
#include "station/http/alarms_api.h"

#include <nlohmann/json.hpp>
#include <string>

#include "station/http/members.h"

namespace soak::station {

using nlohmann::json;

base::Result<json> alarms_answer(const AlarmSender* sender, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return sender == nullptr ? json{{"ways", json::array()}} : sender->document();
}

base::Result<json> test_alarms(AlarmSender* sender, const json& body) {
  if (auto known = only_members(body, {"user"}); !known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  if (sender == nullptr) return base::bad_input("this station tells nobody of its alarms", "alarms");
  return sender->test(*user);
}

}  // namespace soak::station
