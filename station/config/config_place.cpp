// SPDX-License-Identifier: Apache-2.0
#include "station/config/config_place.h"

#include <system_error>

#include "settings/reader.h"
#include "station/config/unit_type_file.h"
#include "station/http/web_files.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

bool is_template(const std::filesystem::path& file) {
  const auto text = settings::read_text(file.string());
  return text && *text == config_template();
}

/// One that cannot be looked at is there: reading it says why it cannot be read.
bool is_there(const std::filesystem::path& file) {
  std::error_code failure;
  return std::filesystem::exists(file, failure) || failure;
}

}  // namespace

std::string config_template() {
  constexpr std::string_view kPlace = "@procedures@";
  const std::string folder = default_unit_type_folder().parent_path().string();
  std::string text(find_web_file("station.toml")->content);
  for (std::size_t at = text.find(kPlace); at != std::string::npos; at = text.find(kPlace, at + folder.size())) {
    text.replace(at, kPlace.size(), folder);
  }
  return text;
}

base::Result<ConfigPlace> place_of_config(const std::filesystem::path& file, std::string_view data_option) {
  if (!file.empty() && !is_template(file)) return ConfigPlace{file, is_there(file), false};
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  const std::filesystem::path usual = *folder / "station.toml";
  return ConfigPlace{usual, is_there(usual), true};
}

}  // namespace soak::station
