// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "station/import/columns_map.h"
#include "station/import/source_recording.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

using station::CsvOptions;
using station::SourceRecording;
using station::SourceRun;

constexpr std::string_view kDivider = "\n----\n";

void check_times(const SourceRun& run) {
  require(run.channels.front().name == "t_s", "the first channel is the time");
  double last_s = -std::numeric_limits<double>::infinity();
  for (const double t_s : values_of(run.columns.front(), run.channels.front().scale, run.channels.front().offset)) {
    require(std::isfinite(t_s) && t_s > last_s, "times are finite and rise");
    last_s = t_s;
  }
}

void check_columns(const SourceRun& run) {
  require(run.rows() > 0, "a run has rows");
  require(run.channels.size() == run.columns.size(), "each channel has its column");
  for (std::size_t i = 0; i < run.columns.size(); ++i) {
    const db::Column& column = run.columns[i];
    require(column.rows() == run.rows(), "all columns have the same number of rows");
    require(column.present.empty() || column.present.size() == run.rows(), "presence has one byte per row");
    require(column.type == run.channels[i].type, "channel and column have the same type");
    for (const double value : values_of(column, 1.0, 0.0)) {
      require(!std::isinf(value), "no number is infinite");
    }
  }
}

std::size_t checked_rows(const SourceRecording& recording) {
  std::size_t rows = 0;
  require(!recording.runs.empty(), "a recording has a run");
  for (const SourceRun& run : recording.runs) {
    check_columns(run);
    check_times(run);
    rows += run.rows();
  }
  return rows;
}

bool check(std::string_view text, CsvOptions options) {
  const auto strict = parse_csv_recording(text, "fuzz.csv", options);
  options.skip_bad = true;
  const auto lenient = parse_csv_recording(text, "fuzz.csv", options);
  if (lenient) (void)checked_rows(*lenient);
  if (!strict) {
    require(!strict.error().message.empty(), "a refusal says why");
    return false;
  }
  require(strict->bad_rows.empty(), "without --skip-bad no row is left out");
  require(lenient && lenient->bad_rows.empty(), "--skip-bad leaves no good row out");
  require(checked_rows(*strict) == checked_rows(*lenient), "--skip-bad keeps all good rows");
  return true;
}

}  // namespace

bool csv_recording(Input input) {
  const std::string_view text = as_text(input);
  const std::size_t divider = text.find(kDivider);
  if (divider == std::string_view::npos) return check(text, {});
  const auto map = station::parse_columns_map(text.substr(0, divider), "fuzz.toml");
  return map && check(text.substr(divider + kDivider.size()), {.map = *map});
}

}  // namespace soak::fuzz
