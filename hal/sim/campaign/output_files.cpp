// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/campaign/output_files.h"

#include <fstream>
#include <system_error>

namespace soak::hal::sim {

base::Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return base::bad_input("cannot make this folder (" + error.message() + ")", folder.string());
  return {};
}

base::Status write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) return base::fail(base::ErrorKind::internal, "cannot write this file", path.string());
  return {};
}

}  // namespace soak::hal::sim
