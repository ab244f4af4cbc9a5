// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::station {

/// A file of web/ as it was when the program was built.
struct WebFile {
  std::string_view name;
  std::string_view content;
};

/// The file with that name, null if there is none. (Defined in a source that cmake/EmbedFiles.cmake generates.)
[[nodiscard]] const WebFile* find_web_file(std::string_view name);

}  // namespace soak::station
