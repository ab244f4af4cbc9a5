// SPDX-License-Identifier: Apache-2.0
#include "station/import/source_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "base/text.h"
#include "base/units.h"
#include "calib/vocabulary/sensor.h"
#include "station/import/channel.h"
#include "station/import/detail/csv_columns.h"
#include "station/import/slow_channel.h"
#include "station/io/csv_scanner.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

constexpr double kWarmest_c = 1000.0;
constexpr double kLargestTime_s = 1e11;  // Unix time in seconds is 1.8e9

/// Why the value read last cannot be a time, a temperature or the rate of a fixture; nothing where it can. Sensors are
/// not checked here: the fit judges them.
std::optional<std::string> implausible(const db::ChannelInfo& channel, const ColumnBuilder& builder) {
  const bool temperature = channel.name.starts_with("temp_");
  const bool rate = is_fixture_rate(channel);
  if (!temperature && !rate && channel.name != "t_s") return std::nullopt;
  const double value = conversion_to_csv(channel.unit)(builder.pending_value());
  if (temperature && (value < -base::kZeroCelsius_k || value > kWarmest_c)) {
    return fmt::format("{} °C is not plausible for a unit: check the unit in the column's name", value);
  }
  if (rate && std::abs(value) > kFastestFixture_dps) {
    return fmt::format(
        "{} deg/s is not plausible for a fixture (at most {} deg/s): check the unit in the column's name", value,
        kFastestFixture_dps);
  }
  if (channel.name == "t_s" && std::abs(value) > kLargestTime_s) {
    return fmt::format("{} s is not plausible for a recording: check the unit of the time", value);
  }
  return std::nullopt;
}

constexpr std::size_t kRowsPerProgress = 20000;

/// The columns of the run that is being read.
struct OpenRun {
  std::string label;
  std::size_t first_line = 0;
  std::vector<ColumnBuilder> builders;
  double last_t_s = -std::numeric_limits<double>::infinity();
  std::size_t last_line = 0;
};

class RecordingParser {
 public:
  RecordingParser(std::string_view text, std::filesystem::path path, const CsvOptions& options)
      : text_(text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text),
        path_(std::move(path)),
        options_(options),
        scanner_(text_, options.map.separator) {}

  base::Result<SourceRecording> parse() {
    if (auto status = read_header(); !status) return base::forward_error(status);
    std::size_t rows = 0;
    while (true) {
      const auto more = scanner_.next(cells_);
      if (!more) return base::bad_input(more.error().message, path_.string() + ", " + more.error().where);
      if (!*more) break;
      if (rows++ < options_.map.skip_rows) continue;
      if (auto status = read_row(); !status) return base::forward_error(status);
      if (rows % kRowsPerProgress == 0 && options_.progress && !options_.progress(share_read())) {
        return base::fail(base::ErrorKind::internal, "interrupted: nothing was imported", path_.string());
      }
    }
    if (auto status = close_run(); !status) return base::forward_error(status);
    return finish();
  }

 private:
  [[nodiscard]] double share_read() const {
    return static_cast<double>(scanner_.offset()) / static_cast<double>(text_.size());
  }

  [[nodiscard]] std::string place(std::size_t line, std::string_view column = {}) const {
    if (column.empty()) return fmt::format("{}, line {}", path_.string(), line);
    return fmt::format("{}, line {}, column '{}'", path_.string(), line, column);
  }

  base::Status read_header() {
    const auto more = scanner_.next(cells_);
    if (!more) return base::bad_input(more.error().message, path_.string() + ", " + more.error().where);
    if (!*more) {
      return base::bad_input("the file is empty: it must begin with a header line such as t_s,temp_c,gx_dps",
                             path_.string());
    }
    auto layout = layout_of_csv(cells_, options_.map);
    if (!layout) return base::bad_input(layout.error().message, place(scanner_.line()));
    layout_ = *std::move(layout);
    return {};
  }

  base::Status read_row() {
    if (cells_.size() != layout_.cells) {
      const bool short_row = cells_.size() < layout_.cells;
      return reject_row(
          {}, fmt::format("the line has {} cells where the header has {}: {}", cells_.size(), layout_.cells,
                          short_row ? "the line is truncated" : "cells that contain a separator need quotes"));
    }
    if (auto status = enter_run(); !status) return status;
    for (std::size_t i = 0; i < layout_.columns.size(); ++i) {
      const ColumnPlan& plan = layout_.columns[i];
      const auto problem = run_->builders[i].read(plan.constant ? *plan.constant : cells_[plan.cell]);
      if (problem && !problem->bad_row) {
        return base::bad_input(problem->reason, place(scanner_.line(), plan.header));
      }
      if (problem) return reject_row(plan.header, problem->reason);
      if (auto reason = implausible(plan.channel, run_->builders[i]))
        return reject_row(plan.header, *std::move(reason));
    }
    return commit_row();
  }

  base::Status commit_row() {
    const ColumnPlan& time = layout_.columns.front();
    const double t_s = run_->builders.front().pending_value();
    if (std::isnan(t_s)) return reject_row(time.header, "the cell is empty: every row needs a time");
    if (!(t_s > run_->last_t_s)) {
      return base::bad_input(fmt::format("the time {} from {} s (line {}) to {} s within run '{}': it must increase; a "
                                         "new run needs another text in the column 'run'",
                                         t_s == run_->last_t_s ? "does not change" : "decreases", run_->last_t_s,
                                         run_->last_line, t_s, run_->label),
                             place(scanner_.line(), time.header));
    }
    run_->last_t_s = t_s;
    run_->last_line = scanner_.line();
    for (ColumnBuilder& builder : run_->builders) builder.commit();
    return {};
  }

  /// Makes the run that the current row belongs to the open one.
  base::Status enter_run() {
    if (!layout_.run) {
      if (!run_) open_run(path_.stem().string());
      return {};
    }
    const std::string_view label = cells_[*layout_.run];
    if (run_ && run_->label == label) return {};
    if (trimmed(label).empty()) {
      return base::bad_input("the cell is empty: every row needs the label of its run",
                             place(scanner_.line(), layout_.run_header));
    }
    if (labels_.contains(label)) {
      return base::bad_input(
          fmt::format("run '{}' continues here after another run: the rows of a run must be contiguous", label),
          place(scanner_.line(), layout_.run_header));
    }
    if (auto status = close_run(); !status) return status;
    if (!base::is_utf8(label)) {
      return base::bad_input("the run's label is not UTF-8 text: save the file as UTF-8",
                             place(scanner_.line(), layout_.run_header));
    }
    if (!base::is_plain_line(label)) {
      return base::bad_input(
          "the run's label must be plain text without control characters, line separators or marks that change the "
          "text's direction",
          place(scanner_.line(), layout_.run_header));
    }
    open_run(std::string(label));
    return {};
  }

  void open_run(std::string label) {
    labels_.insert(label);
    run_.emplace();
    run_->label = std::move(label);
    run_->first_line = scanner_.line();
    for (const ColumnPlan& plan : layout_.columns) run_->builders.emplace_back(plan);
  }

  base::Status close_run() {
    if (!run_) return {};
    bool has_sensor = false;
    SourceRun run{std::move(run_->label), run_->first_line, {}, {}, {}};
    for (ColumnBuilder& builder : run_->builders) {
      const bool has_values = builder.values() > 0;
      auto [channel, column] = builder.finish();
      if (channel.name == "temp_c" && !has_values) {
        return base::bad_input(fmt::format("run '{}' has no temperature", run.label),
                               place(run.first_line, channel.source_name));
      }
      has_sensor = has_sensor || (has_values && calib::sensor_named(channel.name));
      run.channels.push_back(std::move(channel));
      run.columns.push_back(std::move(column));
    }
    if (!has_sensor) {
      return base::bad_input(fmt::format("run '{}' has no sensor values", run.label), place(run.first_line));
    }
    add_positions(run);
    recording_.runs.push_back(std::move(run));
    run_.reset();
    return {};
  }

  void add_positions(SourceRun& run) const {
    for (const db::ChannelInfo& channel : run.channels) {
      if (channel.name != "position") continue;
      for (const std::string& label : channel.labels) {
        const auto named = calib::position_named(label);
        for (const calib::Position& position : options_.map.positions) {
          if (position.label != (named ? named->label : label)) continue;
          run.positions.push_back(position);
          run.positions.back().label = label;
        }
      }
    }
  }

  base::Status reject_row(std::string_view column, std::string reason) {
    if (!options_.skip_bad) {
      return base::bad_input(std::move(reason) + " (--skip-bad skips such rows and lists them)",
                             place(scanner_.line(), column));
    }
    recording_.bad_rows.push_back({scanner_.line(), std::string(column), std::move(reason)});
    return {};
  }

  base::Result<SourceRecording> finish() {
    if (recording_.runs.empty()) {
      return base::bad_input("the file has no usable row below its header", path_.string());
    }
    // A file whose lines end properly and whose last line does not was probably cut while it was written or copied.
    if (!scanner_.row_was_ended()) {
      recording_.warnings.push_back(
          fmt::format("{}: the last line has no line end; the file may be truncated, and its last number with it",
                      place(scanner_.line())));
    }
    return std::move(recording_);
  }

  std::string_view text_;
  std::filesystem::path path_;
  const CsvOptions& options_;
  CsvScanner scanner_;
  std::vector<std::string_view> cells_;
  CsvLayout layout_;
  std::optional<OpenRun> run_;
  std::set<std::string, std::less<>> labels_;
  SourceRecording recording_;
};

}  // namespace

base::Result<SourceRecording> parse_csv_recording(std::string_view text, const std::filesystem::path& path,
                                                  const CsvOptions& options) {
  return RecordingParser(text, path, options).parse();
}

base::Result<SourceRecording> read_csv_recording(const std::filesystem::path& path, const CsvOptions& options) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  return parse_csv_recording(*text, path, options);
}

}  // namespace soak::station
