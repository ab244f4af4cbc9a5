// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "db/run/sample.h"
#include "station/import/channel.h"
#include "station/import/columns_map.h"

namespace soak::station {

/// Where the cells of a channel come from and what they mean.
struct ColumnPlan {
  std::size_t cell = 0;                 ///< index in the row; unused for a constant
  std::optional<std::string> constant;  ///< the cell of every row
  ColumnRole role = ColumnRole::auxiliary;
  std::string header;                  ///< as in the file, for messages
  bool is_label = false;               ///< text for certain; an auxiliary channel is also text if its first cell is
  std::optional<db::SampleType> type;  ///< absent = the narrowest that loses nothing
  db::ChannelInfo channel;             ///< all but the type and labels that are found from the cells
  /// Says what is wrong with a label that was not seen before; empty = accepts all.
  std::function<std::optional<std::string>(std::string_view)> refuse_label;
};

/// Why a cell cannot be used.
struct CellProblem {
  std::string reason;
  bool bad_row = true;  ///< the row may be left out; otherwise the whole file is refused
};

/// Collects one channel of one run. Cells are read first and committed when the whole row has proved sound.
class ColumnBuilder {
 public:
  explicit ColumnBuilder(const ColumnPlan& plan);

  /// Reads a cell as the channel's next value; an empty one is no value. Returns the problem, if there is one.
  [[nodiscard]] std::optional<CellProblem> read(std::string_view cell);
  /// Appends what read() has read last.
  void commit();

  /// The value read last, scale and offset applied; NaN for an empty cell. Numbers only.
  [[nodiscard]] double pending_value() const;
  [[nodiscard]] std::size_t values() const { return values_; }

  /// The channel with the type and labels that were found, and its numbers. Leaves the builder empty.
  [[nodiscard]] std::pair<db::ChannelInfo, db::Column> finish();

 private:
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>()(text); }
  };
  struct Pending {
    bool present = false;
    bool is_label = false;
    bool is_whole = false;
    std::int64_t whole = 0;
    double real = 0.0;
    std::string_view label;  // only if it is new
  };

  std::optional<CellProblem> read_number(std::string_view cell);
  std::optional<CellProblem> read_label(std::string_view cell);
  bool reads_as_number(std::string_view cell);
  void commit_number(bool is_whole, std::int64_t whole, double real);
  [[nodiscard]] db::SampleType final_type() const;

  const ColumnPlan* plan_;
  Pending pending_;
  bool decided_;  // whether numbers or labels
  bool is_label_;
  bool is_real_ = false;
  std::size_t values_ = 0;
  std::vector<std::int64_t> wholes_;
  std::vector<double> reals_;
  std::vector<std::uint8_t> present_;
  std::vector<std::string> labels_;
  std::unordered_map<std::string, std::int64_t, TextHash, std::equal_to<>> label_numbers_;
};

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
