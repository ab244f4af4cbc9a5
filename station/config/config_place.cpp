// SPDX-License-Identifier: Apache-2.0
#include "station/config/config_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <system_error>
#include <utility>

#include "settings/reader.h"
#include "station/config/unit_type_file.h"
#include "station/http/web_files.h"
#include "station/io/data_folder.h"

namespace soak::station {
namespace {

/// Where the comment of a line begins: its end where it has none.
std::size_t comment_in(std::string_view line) {
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
    if (line[i] == '#' && !is_quoted) return i;
  }
  return line.size();
}

/// What a configuration says: without comments, empty lines and spaces at the ends, and of a map its file's name alone.
std::string essence_of(const std::string& text) {
  constexpr std::string_view kBlank = " \t\r";
  constexpr std::string_view kMap = "map = \"";
  std::string essence;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(comment_in(line));
    line.erase(line.find_last_not_of(kBlank) + 1);
    line.erase(0, std::min(line.size(), line.find_first_not_of(kBlank)));
    if (line.empty()) continue;
    const std::size_t name = line.rfind('/');
    if (line.starts_with(kMap) && name != std::string::npos) line.erase(kMap.size(), name + 1 - kMap.size());
    essence += line + '\n';
  }
  return essence;
}

bool is_template(const std::filesystem::path& file) {
  const auto text = settings::read_text(file.string());
  return text && essence_of(*text) == essence_of(config_template());
}

/// One that cannot be looked at is there: reading it says why it cannot be read.
bool is_there(const std::filesystem::path& file) {
  std::error_code failure;
  return std::filesystem::exists(file, failure) || failure;
}

}  // namespace

std::string config_template() {
  constexpr std::string_view kPlace = "@procedures@";
  const std::string folder = shipped_procedures().string();
  std::string text(find_web_file("station.toml")->content);
  for (std::size_t at = text.find(kPlace); at != std::string::npos; at = text.find(kPlace, at + folder.size())) {
    text.replace(at, kPlace.size(), folder);
  }
  return text;
}

base::Result<ConfigPlace> place_of_config(const std::filesystem::path& file, std::string_view data_option,
                                          const std::filesystem::path& service_folder) {
  ConfigPlace place;
  if (!file.empty() && !is_template(file)) {
    place.file = file;
    place.is_there = is_there(file);
    return place;
  }
  const auto folder = data_folder(data_option);
  if (!folder) return base::forward_error(folder);
  place.passed_over = file;
  place.file = *folder / "station.toml";
  place.is_there = is_there(place.file);
  place.is_usual = true;
  place.searched = {*folder};
  if (place.is_there || file.empty() || !data_option.empty() || *folder == service_folder) return place;
  place.searched.push_back(service_folder);
  const std::filesystem::path of_service = service_folder / "station.toml";
  if (!is_there(of_service)) return place;
  place.file = of_service;
  place.is_there = true;
  place.data = service_folder;
  return place;
}

base::Error no_config_at(const ConfigPlace& place) {
  constexpr std::string_view kTemplate = "'soakd --write-config' prints one to begin with";
  const auto error = [&](std::string text) {
    return base::Error{base::ErrorKind::bad_input, std::move(text), place.file.string()};
  };
  if (!place.is_usual) return error(fmt::format("there is no such file; {}", kTemplate));
  if (place.passed_over.empty()) {
    return error(
        fmt::format("this station is not set up: start soakd and open its page, or write the file; {}", kTemplate));
  }
  std::string folders;
  for (const auto& folder : place.searched) folders += (folders.empty() ? "" : " and ") + folder.string();
  return error(
      fmt::format("{} is still the template that came with Soak and says nothing of this station, and there is "
                  "no station.toml in {}: give --config the file of this station, or --data its data folder. "
                  "A station that is not set up: start soakd and open its page",
                  place.passed_over.string(), folders));
}

}  // namespace soak::station
