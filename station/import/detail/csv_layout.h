// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/import/columns_map.h"
#include "station/import/detail/column_builder.h"

namespace soak::station {

/// What the header line of a CSV file and its columns map make of the columns.
struct CsvLayout {
  std::size_t cells = 0;            ///< of a row
  std::optional<std::size_t> run;   ///< cell that holds the run's label
  std::string run_header;           ///< and its header
  std::vector<ColumnPlan> columns;  ///< the time first, then in the order of the file, then constants
};

/// Refuses nameless, doubled and missing columns, quantities that are given twice, map entries without a column,
/// and a rate of the fixture without a position or with another one in the map.
/// Errors have no place yet: it is the header line of the file. `map` must outlive the layout.
[[nodiscard]] base::Result<CsvLayout> layout_of_csv(const std::vector<std::string_view>& header, const ColumnsMap& map);

}  // namespace soak::station
