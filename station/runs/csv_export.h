// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "db/run/run_file.h"

namespace soak::station {

/// A run as CSV text in canonical units and headers (t_s, run, ..., gx_dps, ..., az_mps2), then auxiliary channels.
[[nodiscard]] base::Result<std::string> canonical_csv(const db::RunFileReader& file, std::string_view unit);

/// A run in the source's own headers and numbers.
struct NativeCsv {
  std::string csv;
  /// Columns map (TOML) without which the CSV would not be imported with the same samples and types; absent where the
  /// CSV alone is enough.
  std::optional<std::string> columns_map;
};

/// Writes the run natively and proves, by reading the text back, that an import gives bit-identical samples, types and
/// labels. Refuses samples that CSV cannot carry (numbers that are not finite).
[[nodiscard]] base::Result<NativeCsv> native_csv(const db::RunFileReader& file, std::string_view unit);

}  // namespace soak::station
