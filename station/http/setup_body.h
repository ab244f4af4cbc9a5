// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "base/result.h"
#include "station/setup/setup_form.h"

namespace soak::station {

/// Where the maps of chambers ("chamber"), fixtures ("fixture") or power switches ("power") lie that Soak comes with.
[[nodiscard]] std::filesystem::path shipped_maps(std::string_view section);

/// Maps that a configuration names already, by section: what the form calls each, and what stands in the file.
class KeptMaps {
 public:
  KeptMaps() = default;
  /// Those of `form`, whose configuration is in `folder`. The form calls a map of shipped_maps() by its file's name,
  /// any other as the configuration does.
  KeptMaps(const SetupForm& form, const std::filesystem::path& folder);

  struct Map {
    std::string choice;
    std::string text;
    std::filesystem::path file;
    bool is_shipped = false;
  };
  /// Null where the section names none.
  [[nodiscard]] const Map* find(std::string_view section) const;

 private:
  void add(const std::string& section, const std::string& text, const std::filesystem::path& folder);
  std::map<std::string, Map, std::less<>> maps_;
};

/// What was entered, as the body of POST /api/v1/setup/check has it. What nobody has entered is empty or absent: that
/// is for check_setup() to judge. Refuses (bad_input, where == the member: "chamber.host", "slots.0.device") members
/// that are not known or of the wrong type, texts of more than a line, and maps that are neither one of shipped_maps()
/// nor `kept`. A member `user` may be there, too.
[[nodiscard]] base::Result<SetupForm> setup_form_of(const nlohmann::json& body, const KeptMaps& kept = {});

/// One controller of such a body, its member `section`: "chamber", "fixture" or "power".
[[nodiscard]] base::Result<EnteredController> controller_of(const nlohmann::json& body, const std::string& section);

}  // namespace soak::station
