// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/warning_list.h"

#include <algorithm>

#include "calib/judge/detail/report_words.h"

namespace soak::calib {

using nlohmann::json;

void WarningList::add(const Warning& warning, std::string_view sensor) {
  json& entry = entry_of(warning);
  if (!sensor.empty()) entry["sensors"].push_back(sensor);
}

void WarningList::add_stored(const json& warnings, std::string_view sensor) {
  for (const json& warning : warnings) add({warning.at("code"), warning.at("text")}, sensor);
}

void WarningList::add_fit(const json& fit) {
  add_stored(fit.at("warnings"));
  for (const auto& [name, sensor] : fit.at("sensors").items()) add_stored(sensor.at("warnings"), name);
}

json WarningList::take() {
  std::ranges::stable_sort(list_.get_ref<json::array_t&>(), {},
                           [](const json& entry) { return urgency_of(entry["code"].get<std::string>()); });
  return std::move(list_);
}

json& WarningList::entry_of(const Warning& warning) {
  const auto same = std::find_if(list_.begin(), list_.end(), [&](const json& entry) {
    return entry["code"] == warning.code && entry["text"] == warning.text;
  });
  if (same != list_.end()) return *same;
  list_.push_back({{"code", warning.code},
                   {"text", warning.text},
                   {"remedy", remedy_of(warning.code)},
                   {"urgency", name_of(urgency_of(warning.code))},
                   {"sensors", json::array()}});
  return list_.back();
}

}  // namespace soak::calib
