// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// Warnings as a page shows them, the gravest first: the same words of several sensors once, with what to do:
/// [{"code", "text", "remedy", "urgency", "sensors"}]; `urgency` is "grave", "act" or "none" (report_words.h).
class WarningList {
 public:
  void add(const Warning& warning, std::string_view sensor = {});
  /// Those of a document: [{"code", "text"}].
  void add_stored(const nlohmann::json& warnings, std::string_view sensor = {});
  /// Those of the document of `soak fit --json`: of the unit, then of its sensors.
  void add_fit(const nlohmann::json& fit);

  [[nodiscard]] nlohmann::json take();

 private:
  nlohmann::json& entry_of(const Warning& warning);

  nlohmann::json list_ = nlohmann::json::array();
};

}  // namespace soak::calib
