// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// Several files in one: the interchange format of POSIX.1-1988 ("ustar"), which every system unpacks. Files are
/// readable by all, belong to nobody and carry the one time that is given, so that the same content gives the same
/// bytes. No library of the build writes archives.
class TarArchive {
 public:
  /// `utc_s`: time of the files, Unix time.
  explicit TarArchive(double utc_s);
  /// Refuses (bad_input) no name, one of more than 100 bytes, of which up to 155 more may be folders in front of it,
  /// and (internal) content of 8 GiB or more: the format has no room for them.
  [[nodiscard]] base::Status add(std::string_view name, std::string_view content);
  /// The archive with its end; no file can be added afterwards.
  [[nodiscard]] std::string finish();

 private:
  long long utc_s_;
  std::string bytes_;
};

}  // namespace soak::station
