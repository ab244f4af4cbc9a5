// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/run/run_file.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/runs/run_document.h"
#include "station/runs/run_series.h"
#include "station/runs/voiding.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr int kMostWaiting = 16;  // threads of the HTTP server that stand here instead of taking an abort
constexpr std::chrono::seconds kPatience{5};

using CountsByRun = std::map<std::pair<std::string, std::string>, db::SegmentCounts>;

base::Result<CountsByRun> counts_by_run(const db::Catalog& catalog) {
  auto counts = catalog.segment_counts();
  if (!counts) return base::forward_error(counts);
  CountsByRun by_run;
  for (db::SegmentCounts& one : *counts) by_run[{one.run_id, one.unit}] = std::move(one);
  return by_run;
}

json end_json(const db::VoidRecord& record) {
  return {{"reason", record.reason}, {"user", record.user}, {"utc_s", record.utc_s}};
}

/// The record that withdraws the whole run, the first one that does; null where there is none.
json void_of_run(const std::vector<db::VoidRecord>& records, const std::string& unit) {
  const auto whole =
      std::ranges::find_if(records, [&](const db::VoidRecord& record) { return record.unit == unit && !record.visit; });
  return whole == records.end() ? json() : end_json(*whole);
}

/// A run as it stands in a list.
base::Result<json> listed_run(const db::Catalog& catalog, const db::RunRow& run, const CountsByRun& counts) {
  json document = stored_run_json(run);
  const auto found = counts.find({run.run_id, run.unit});
  const db::SegmentCounts none;
  const db::SegmentCounts& of_run = found == counts.end() ? none : found->second;
  document["segments"] = {
      {"recorded", of_run.recorded}, {"withdrawn", of_run.withdrawn}, {"rejected", of_run.rejected}};
  document["void"] = nullptr;
  if (!run.voided) return document;
  const auto records = catalog.voids(run.run_id);
  if (!records) return base::forward_error(records);
  document["void"] = void_of_run(*records, run.unit);
  return document;
}

json shown_segment(const calib::Segment& segment, const std::vector<db::VoidRecord>& records) {
  json document = stored_segment_json(segment);
  const auto record = std::ranges::find_if(records, [&](const db::VoidRecord& one) {
    return one.unit == segment.key.unit && is_withdrawn_by(segment.key, one);
  });
  document["void"] = record == records.end() ? json() : end_json(*record);
  return document;
}

base::Result<db::RunRow> sealed_row(const db::Catalog& catalog, const RunName& name) {
  const auto rows = catalog.runs({.unit = name.unit, .campaign = {}, .run = name.run_id});
  if (!rows) return base::forward_error(rows);
  const auto row = std::ranges::find(*rows, name.run_id, &db::RunRow::run_id);
  if (row == rows->end()) {
    return base::bad_input(fmt::format("there is no run {} of unit '{}'; /api/v1/runs lists those that there are. A "
                                       "run is among them once its recording has ended",
                                       name.run_id, name.unit),
                           "run");
  }
  if (!row->sealed) return base::bad_input("the run is not sealed: its recording has not ended", "run");
  return *row;
}

}  // namespace

base::Status WorkedOut::renew(const db::Catalog& catalog, std::string_view day) {
  db::EventFilter only_the_newest;
  only_the_newest.most = 1;
  const auto newest = catalog.find_events(only_the_newest);
  if (!newest) return base::forward_error(newest);
  // A number alone may come again: in a catalog that was restored from a backup.
  const std::string events = newest->empty() ? "none" : newest->front().chain_sha256;
  if (events == events_ && day == day_) return {};
  events_ = events;
  day_ = day;
  of_all_ = nullptr;
  of_unit_.clear();
  return {};
}

base::Result<json> WorkedOut::of_all(const Work& work) {
  if (of_all_.is_null()) {
    auto found = work();
    if (!found) return found;
    of_all_ = *std::move(found);
  }
  return of_all_;
}

base::Result<json> WorkedOut::of(const std::string& unit, const json& job, const Work& work) {
  const auto known = of_unit_.find(unit);
  if (known != of_unit_.end() && known->second.job == job) return known->second.found;
  auto found = work();
  if (!found) return found;
  of_unit_.insert_or_assign(unit, OfUnit{job, *found});
  return found;
}

std::optional<json> KeptAnswers::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(kept_, key, &std::pair<std::string, json>::first);
  return found == kept_.end() ? std::nullopt : std::optional(found->second);
}

void KeptAnswers::keep(const std::string& key, json answer) {
  const std::lock_guard lock(mutex_);
  kept_.emplace_back(key, std::move(answer));
  if (kept_.size() > kMostKept) kept_.pop_front();
}

RunArchive::RunArchive(std::filesystem::path data_folder) : data_folder_(std::move(data_folder)) {}

base::Result<std::unique_lock<std::timed_mutex>> RunArchive::Turn::take() {
  const bool may_wait = ++waiting_ <= kMostWaiting;
  std::unique_lock turn(mutex_, std::defer_lock);
  const bool ours = may_wait && turn.try_lock_for(kPatience);
  --waiting_;
  if (!ours) {
    return base::fail(base::ErrorKind::internal, "too many questions about stored runs at a time; ask again in a while",
                      kBusy);
  }
  return turn;
}

base::Result<json> RunArchive::in_turn(const std::function<base::Result<json>(db::Catalog&)>& work) {
  if (data_folder_.empty()) return base::bad_input("the station has no data folder", "run");
  const auto turn = questions_.take();
  if (!turn) return base::forward_error(turn);
  // Anew for each question: what a catalog has found sound it does not check again.
  auto catalog = reopen_catalog(data_folder_);
  if (!catalog) return base::forward_error(catalog);
  return work(*catalog);
}

base::Result<json> RunArchive::compute(const std::function<base::Result<json>()>& work) {
  const auto turn = computations_.take();
  if (!turn) return base::forward_error(turn);
  return work();
}

base::Result<json> RunArchive::once(const std::string& key, const std::function<base::Result<json>()>& work) {
  if (auto known = kept_.find(key)) return *std::move(known);
  const auto turn = long_works_.take();
  if (!turn) return base::forward_error(turn);
  if (auto known = kept_.find(key)) return *std::move(known);  // the one before has found the same
  auto found = work();
  if (found) kept_.keep(key, *found);
  return found;
}

base::Result<json> RunArchive::list(const db::RunFilter& filter) {
  return in_turn([&](const db::Catalog& catalog) -> base::Result<json> {
    const auto rows = catalog.runs(filter);
    if (!rows) return base::forward_error(rows);
    const auto counts = counts_by_run(catalog);
    if (!counts) return base::forward_error(counts);
    const std::size_t shown = std::min(rows->size(), kMostRuns);
    json list = json::array();
    for (auto row = rows->rbegin(); list.size() < shown; ++row) {
      auto run = listed_run(catalog, *row, *counts);
      if (!run) return run;
      list.push_back(*std::move(run));
    }
    return json{{"runs", std::move(list)}, {"not_listed", rows->size() - shown}};
  });
}

base::Result<json> RunArchive::show(const RunName& name) {
  return in_turn([&](const db::Catalog& catalog) -> base::Result<json> {
    const auto row = sealed_row(catalog, name);
    if (!row) return base::forward_error(row);
    const auto counts = counts_by_run(catalog);
    if (!counts) return base::forward_error(counts);
    auto run = listed_run(catalog, *row, *counts);
    if (!run) return run;
    const auto segments = catalog.recorded_segments(row->run_id, row->unit);
    if (!segments) return base::forward_error(segments);
    const auto records = catalog.voids(row->run_id);
    if (!records) return base::forward_error(records);
    std::string source = row->samples_dropped ? row->samples_dropped->source : "";
    json streams = json::array();
    if (!row->samples_dropped) {
      const auto file = catalog.open_run_file(*row);
      if (!file) return base::forward_error(file);
      source = file->info().source;
      auto read = streams_json(*file, row->unit);
      if (!read) return read;
      streams = *std::move(read);
    }
    json document = {{"run", *std::move(run)},
                     {"source", std::move(source)},
                     {"streams", std::move(streams)},
                     {"segments", json::array()},
                     {"voids", json::array()}};
    for (const calib::Segment& segment : *segments) document["segments"].push_back(shown_segment(segment, *records));
    for (const db::VoidRecord& record : *records) {
      if (record.unit == row->unit) document["voids"].push_back(stored_void_json(record));
    }
    return document;
  });
}

base::Result<json> RunArchive::series(const SeriesRequest& request) {
  if (request.points < 1 || request.points > kMostPoints) {
    return base::bad_input(fmt::format("a series has 1 to {} points", kMostPoints), "points");
  }
  if (request.channels.empty() || request.channels.size() > kMostChannels) {
    return base::bad_input(fmt::format("a series is of 1 to {} channels", kMostChannels), "channel");
  }
  return in_turn([&](const db::Catalog& catalog) -> base::Result<json> {
    const auto row = sealed_row(catalog, request.run);
    if (!row) return base::forward_error(row);
    const auto file = catalog.open_run_file(*row);
    if (!file) return base::forward_error(file);
    const auto stream = stream_named(*file, request.stream, row->unit);
    if (!stream) return base::forward_error(stream);
    auto series = series_json(*file, {*stream, request.channels, request.from_s, request.to_s, request.points});
    if (!series) return series;
    (*series)["run_id"] = row->run_id;
    (*series)["unit"] = row->unit;
    return series;
  });
}

base::Result<json> RunArchive::withdraw(db::VoidRecord record) {
  return in_turn([&](db::Catalog& catalog) -> base::Result<json> {
    const auto row = sealed_row(catalog, {record.run_id, record.unit});
    if (!row) return base::forward_error(row);
    record.utc_s = now_utc_s();
    const auto made = void_part(catalog, *row, std::move(record));
    if (!made) return base::forward_error(made);
    return voided_part_json(*made);
  });
}

}  // namespace soak::station
