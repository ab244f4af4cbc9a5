// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/position.h"
#include "db/run/sample.h"
#include "station/import/channel.h"

namespace soak::station {

/// What a columns map says of one column of a foreign CSV file. Value in the unit of `meaning` = scale · number +
/// offset.
struct MappedColumn {
  std::string source;  ///< header cell in the file
  std::string as;      ///< header in our own grammar: "gx_rps", "t_us", "chamber_c", a name of its own
  HeaderMeaning meaning;
  bool is_label = false;               ///< text, not numbers (always so for phase, sweep, position)
  std::optional<db::SampleType> type;  ///< absent = the narrowest that loses nothing
  double scale = 1.0;
  double offset = 0.0;
  std::vector<std::string> labels;  ///< labels that take the first numbers, in this order
};

/// How to read a CSV file that does not have our headers (docs/csv-format.md).
struct ColumnsMap {
  char separator = ',';
  std::size_t skip_rows = 0;  ///< rows after the header that are left out
  std::vector<MappedColumn> columns;
  std::vector<std::pair<std::string, std::string>> constants;  ///< header in our grammar, cell of every row
  std::vector<calib::Position> positions;  ///< beyond the six named ones, and those of the six with an azimuth
};

/// Reads a columns map. Refuses the first syntax error, or all semantic mistakes at once, each with its line.
[[nodiscard]] base::Result<ColumnsMap> read_columns_map(const std::filesystem::path& path);
[[nodiscard]] base::Result<ColumnsMap> parse_columns_map(std::string_view toml, const std::string& where);

/// The TOML text that parse_columns_map() reads back as the same map.
[[nodiscard]] std::string columns_map_text(const ColumnsMap& map);

}  // namespace soak::station
