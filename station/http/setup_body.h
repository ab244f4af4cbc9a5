// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "base/result.h"
#include "station/setup/setup_form.h"

namespace soak::station {

/// Where the maps of chambers ("chamber"), fixtures ("fixture") or power switches ("power") lie that Soak comes with.
[[nodiscard]] std::filesystem::path shipped_maps(std::string_view section);

/// What was entered, as the body of POST /api/v1/setup/check has it. What nobody has entered is empty or absent: that
/// is for check_setup() to judge. Refuses (bad_input, where == the member: "chamber.host", "slots.0.device") members
/// that are not known or of the wrong type, texts of more than a line, and maps that are none of shipped_maps(). A
/// member `user` may be there, too.
[[nodiscard]] base::Result<SetupForm> setup_form_of(const nlohmann::json& body);

/// One controller of such a body, its member `section`: "chamber", "fixture" or "power".
[[nodiscard]] base::Result<EnteredController> controller_of(const nlohmann::json& body, const std::string& section);

}  // namespace soak::station
