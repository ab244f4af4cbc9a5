// SPDX-License-Identifier: Apache-2.0
#include "station/runs/signal_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "calib/estimate/unit_input.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/vocabulary/sensor.h"
#include "db/run/run_file.h"
#include "station/import/channel.h"
#include "station/io/csv_scanner.h"
#include "station/io/data_folder.h"
#include "station/io/output.h"
#include "station/io/text_file.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

constexpr double kRateTolerance = 0.01;
constexpr double kLargest = 1e100;
constexpr double kRemarkableShare = 0.001;
constexpr double kRemarkableScatter = 0.1;

/// A unit of our headers as results print it; empty where it is none.
std::string printed_unit_of(std::string_view unit) {
  if (unit == "dps") return "deg/s";
  if (unit == "rps") return "rad/s";
  if (unit == "degph") return "deg/h";
  if (unit == "mps2") return "m/s2";
  if (unit == "c") return "K";
  if (unit == "deg" || unit == "rad" || unit == "g" || unit == "mg" || unit == "v") return std::string(unit);
  if (unit == "mps") return "m/s";
  return {};
}

/// What the suffix of a header says: "gx_dps", "rate_dps".
std::string unit_of_header(std::string_view header) {
  const std::size_t underscore = header.rfind('_');
  return underscore == std::string_view::npos ? std::string() : printed_unit_of(header.substr(underscore + 1));
}

/// A column of values, with their times.
struct TimedColumn {
  bool timed = false;
  std::vector<double> t_s;  ///< empty where the file has no time column
  std::vector<double> values;
};

/// Reads two columns of a CSV file.
class ColumnReader {
 public:
  ColumnReader(std::string_view text, std::string path, std::string column)
      : scanner_(text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text, ','),
        path_(std::move(path)),
        column_(std::move(column)) {}

  base::Result<TimedColumn> read() {
    if (auto status = read_header(); !status) return base::forward_error(status);
    while (true) {
      const auto more = scanner_.next(cells_);
      if (!more) return base::bad_input(more.error().message, path_ + ", " + more.error().where);
      if (!*more) return finished();
      if (interrupted()) return base::fail(base::ErrorKind::internal, "interrupted", path_);
      if (auto status = read_row(); !status) return base::forward_error(status);
    }
  }

 private:
  [[nodiscard]] std::string place(std::string_view column) const {
    return fmt::format("{}, line {}, column '{}'", path_, scanner_.line(), column);
  }

  base::Status read_header() {
    const auto more = scanner_.next(cells_);
    if (!more) return base::bad_input(more.error().message, path_ + ", " + more.error().where);
    if (!*more) return base::bad_input("the file is empty: it must begin with a header line such as t_s,gx_dps", path_);
    cell_count_ = cells_.size();
    line_ = scanner_.line();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      names.emplace_back(trimmed(cells_[i]));
      const auto meaning = meaning_of_header(names.back());
      if (meaning && meaning->role == ColumnRole::time && !time_) {
        time_ = i;
        time_header_ = names.back();
        time_scale_ = meaning->scale;
      }
      if (names.back() != column_) continue;
      if (value_)
        return base::bad_input(fmt::format("column '{}' is duplicated: rename one of the two", column_), path_);
      value_ = i;
    }
    result_.timed = time_.has_value();
    if (value_) return {};
    return base::bad_input(fmt::format("unknown column '{}': the file has {}", column_, fmt::join(names, ", ")), path_);
  }

  [[nodiscard]] base::Result<TimedColumn> finished() {
    if (!result_.values.empty()) return std::move(result_);
    return base::bad_input("the file has no rows below its header", path_);
  }

  base::Result<double> number(std::string_view cell, std::string_view column) const {
    const auto value = base::parse_double(cell);
    if (value && std::abs(*value) > kLargest) {
      return base::bad_input(fmt::format("{:g} is not plausible for a sensor: must be at most 1e100", *value),
                             place(column));
    }
    if (value) return *value;
    return base::bad_input(
        fmt::format("'{}' is not a number: write a decimal number with a dot, or leave the cell empty", cell),
        place(column));
  }

  base::Status read_row() {
    if (cells_.size() != cell_count_) {
      return base::bad_input(fmt::format("the line has {} cells where the header has {}", cells_.size(), cell_count_),
                             fmt::format("{}, line {}", path_, scanner_.line()));
    }
    // In a file of one column an empty cell is an empty line, which the scanner passes over.
    if (cell_count_ == 1) {
      result_.values.insert(result_.values.end(), scanner_.line() - line_ - 1,
                            std::numeric_limits<double>::quiet_NaN());
    }
    line_ = scanner_.line();
    const std::string_view cell = trimmed(cells_[*value_]);
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!cell.empty()) {
      const auto parsed = number(cell, column_);
      if (!parsed) return base::forward_error(parsed);
      value = *parsed;
    }
    if (time_) {
      const auto time = number(trimmed(cells_[*time_]), time_header_);
      if (!time) return base::forward_error(time);
      const double t_s = *time * time_scale_;
      if (!result_.t_s.empty() && !(t_s > result_.t_s.back())) {
        return base::bad_input(
            fmt::format("the time goes from {} to {} s: it must increase (split the file into one file per run)",
                        result_.t_s.back(), t_s),
            place(time_header_));
      }
      result_.t_s.push_back(t_s);
    }
    result_.values.push_back(value);
    return {};
  }

  CsvScanner scanner_;
  std::string path_;
  std::string column_;
  std::size_t cell_count_ = 0;
  std::size_t line_ = 0;  ///< of the last row
  std::optional<std::size_t> time_;
  std::string time_header_;
  double time_scale_ = 1.0;
  std::optional<std::size_t> value_;
  std::vector<std::string_view> cells_;
  TimedColumn result_;
};

/// What must be said of samples that are not as even as analyses take them to be.
std::vector<std::string> remarks_on(const calib::signal::SampleGrid& grid) {
  std::vector<std::string> remarks;
  const auto missing = std::count_if(grid.values.begin(), grid.values.end(), [](double v) { return std::isnan(v); });
  const double share = static_cast<double>(missing) / static_cast<double>(grid.values.size());
  if (share > kRemarkableShare) {
    remarks.push_back(
        fmt::format("{} of {} samples are missing ({:.1f} %)", missing, grid.values.size(), 100.0 * share));
  }
  if (grid.scatter > kRemarkableScatter) {
    remarks.push_back(
        fmt::format("the times scatter by {:.0f} % of a step (RMS) about an even {:.6g} Hz, which the analysis assumes",
                    100.0 * grid.scatter, grid.rate_hz));
  }
  return remarks;
}

calib::SignalRecord record_of(std::string column, std::string unit, calib::signal::SampleGrid grid) {
  std::vector<std::string> remarks = remarks_on(grid);
  return {std::move(column),   std::move(unit),        grid.rate_hz,
          std::move(grid.t_s), std::move(grid.values), std::move(remarks)};
}

/// Row by row at the rate that the user gives.
calib::signal::SampleGrid grid_at(double rate_hz, std::vector<double> values) {
  calib::signal::SampleGrid grid{rate_hz, {}, std::move(values)};
  grid.t_s.reserve(grid.values.size());
  for (std::size_t i = 0; i < grid.values.size(); ++i) grid.t_s.push_back(static_cast<double>(i) / rate_hz);
  return grid;
}

/// A channel of a run file.
struct ChannelOf {
  std::size_t stream = 0;
  std::size_t channel = 0;
};

/// Appends rows of a channel in printed units.
base::Status append_values(const db::RunFileReader& file, const ChannelOf& of, const db::RowSpan& rows,
                           std::vector<double>& values) {
  const db::ChannelInfo& info = file.streams()[of.stream].channels[of.channel];
  const auto column = file.read(of.stream, of.channel, rows.first, rows.count);
  if (!column) return base::forward_error(column);
  const std::vector<double> read = db::values_of(*column, info.scale, info.offset);
  std::ranges::transform(read, std::back_inserter(values), conversion_to_csv(info.unit));
  return {};
}

/// The channel of the stream that goes by this name or by this canonical header.
base::Result<std::size_t> channel_named(const std::vector<db::ChannelInfo>& channels, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].unit == "label" || channels[i].name == "t_s") continue;
    if (channels[i].name == name || canonical_header(channels[i].name) == name) return i;
    names.push_back(channels[i].name);
  }
  return base::bad_input(fmt::format("the run has no channel '{}': it has {}", name, fmt::join(names, ", ")),
                         "--column");
}

/// Segments to analyse, and how many of those asked for the data gate has rejected.
struct Selection {
  std::vector<calib::Segment> segments;
  std::size_t rejected = 0;
};

bool gate_rejects(const calib::Segment& segment, std::optional<calib::Sensor> sensor) {
  return sensor ? calib::is_rejected(segment, *sensor) : calib::is_rejected(segment);
}

base::Status explain_empty(const Selection& selection, bool run_is_empty, const std::string& run) {
  if (selection.rejected > 0) {
    return base::bad_input("the data gate rejected every segment of this selection ('soak runs show' says why)", run);
  }
  if (run_is_empty) return base::bad_input("the run has no segments: it has ramps, moves and voided parts only", run);
  return base::bad_input("no segment of the run is of this visit and position ('soak runs show' lists them)", run);
}

base::Result<Selection> matching_segments(const db::Catalog& catalog, const db::RunRow& run, const RunPart& part,
                                          std::optional<calib::Sensor> sensor) {
  auto all = catalog.segments(run.run_id, run.unit, false);
  if (!all) return base::forward_error(all);
  Selection selection;
  for (calib::Segment& segment : *all) {
    const bool wanted = (!part.visit || segment.key.visit == *part.visit) &&
                        (!part.position || segment.key.position == *part.position) &&
                        (!part.attempt || segment.key.attempt == *part.attempt);
    if (!wanted) continue;
    if (gate_rejects(segment, sensor)) {
      ++selection.rejected;
    } else {
      selection.segments.push_back(std::move(segment));
    }
  }
  if (!selection.segments.empty()) return selection;
  return base::forward_error(explain_empty(selection, all->empty(), run.label));
}

std::string unit_of_channel(const db::ChannelInfo& channel) {
  if (const auto sensor = calib::sensor_named(channel.name)) return std::string(calib::printed_unit(*sensor));
  return channel.name.ends_with("_c") ? "K" : printed_unit_of(channel.unit);
}

}  // namespace

base::Result<calib::SignalRecord> read_csv_signal(const std::filesystem::path& path, const std::string& column,
                                                  std::optional<double> rate_hz) {
  auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  auto read = ColumnReader(*text, path.string(), column).read();
  if (!read) return base::forward_error(read);
  std::string().swap(*text);  // as large as the record itself
  std::string unit = unit_of_header(column);
  if (!read->timed) {
    if (!rate_hz) return base::bad_input("the file has no time column (t_s, t_ms or t_us): give the rate", "--rate-hz");
    return record_of(column, std::move(unit), grid_at(*rate_hz, std::move(read->values)));
  }
  auto grid = calib::signal::equally_spaced(read->t_s, read->values);
  if (!grid) return base::bad_input(grid.error().message, fmt::format("{}, column '{}'", path.string(), column));
  if (rate_hz && std::abs(grid->rate_hz / *rate_hz - 1.0) > kRateTolerance) {
    return base::bad_input(fmt::format("{:g} Hz: the times in the file say {:g} Hz (omit the option to use that rate)",
                                       *rate_hz, grid->rate_hz),
                           "--rate-hz");
  }
  if (rate_hz) grid->rate_hz = *rate_hz;
  return record_of(column, std::move(unit), *std::move(grid));
}

base::Result<calib::SignalRecord> read_run_signal(const db::Catalog& catalog, const RunPart& part,
                                                  const std::string& channel_name) {
  const auto run = find_run(catalog, part.run);
  if (!run) return base::forward_error(run);
  const auto file = catalog.open_run_file(*run);
  if (!file) return base::forward_error(file);
  const auto stream = imu_stream(*file, run->unit);
  if (!stream) return base::forward_error(stream);
  const auto& channels = file->streams()[*stream].channels;
  const auto channel = channel_named(channels, channel_name);
  if (!channel) return base::forward_error(channel);
  const auto selection = matching_segments(catalog, *run, part, calib::sensor_named(channels[*channel].name));
  if (!selection) return base::forward_error(selection);
  std::vector<double> t_s;
  std::vector<double> values;
  std::vector<std::size_t> breaks;
  for (const calib::Segment& segment : selection->segments) {
    const auto span = file->rows_between(*stream, segment.t_start_s, segment.t_end_s);
    if (!span) return base::forward_error(span);
    const std::uint64_t left = part.most_rows.value_or(UINT64_MAX) - values.size();
    const std::uint64_t count = std::min(span->count, left);
    breaks.push_back(values.size());
    if (auto read = append_values(*file, {*stream, 0}, {span->first, count}, t_s); !read) {
      return base::forward_error(read);
    }
    if (auto read = append_values(*file, {*stream, *channel}, {span->first, count}, values); !read) {
      return base::forward_error(read);
    }
  }
  auto grid = calib::signal::equally_spaced(t_s, values, breaks);
  if (!grid) return base::bad_input(grid.error().message, fmt::format("run {}, {}", run->label, channel_name));
  auto record = record_of(channels[*channel].name, unit_of_channel(channels[*channel]), *std::move(grid));
  if (selection->rejected > 0) {
    record.remarks.push_back(
        fmt::format("segments that the data gate rejected and that are not used: {} ('soak runs show' says why)",
                    selection->rejected));
  }
  return record;
}

}  // namespace soak::station
