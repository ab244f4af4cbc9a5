// SPDX-License-Identifier: Apache-2.0
#include "station/runs/voiding.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "station/runs/run_document.h"

namespace soak::station {
namespace {

std::string list_of_segments(const std::vector<calib::Segment>& segments) {
  std::string text;
  for (const calib::Segment& segment : segments) {
    text += fmt::format("{}{}/{}/{}", text.empty() ? "" : ", ", segment.key.visit, segment.key.position,
                        segment.key.attempt);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

bool is_withdrawn_by(const calib::SegmentKey& key, const db::VoidRecord& record) {
  return key.visit == record.visit.value_or(key.visit) && key.position == record.position.value_or(key.position) &&
         key.attempt == record.attempt.value_or(key.attempt);
}

base::Result<VoidedPart> void_part(db::Catalog& catalog, const db::RunRow& run, db::VoidRecord record) {
  if (run.voided) return base::bad_input("the whole run is already voided", run.run_id);
  const auto segments = catalog.segments(run.run_id, run.unit, false);
  if (!segments) return base::forward_error(segments);
  const auto withdrawn = static_cast<std::size_t>(
      std::ranges::count_if(*segments, [&](const auto& segment) { return is_withdrawn_by(segment.key, record); }));
  if (record.visit && withdrawn == 0) {
    return base::bad_input(
        fmt::format("the run has no such segment, or it is already voided; it has (visit/position/attempt): {}",
                    list_of_segments(*segments)),
        run.run_id);
  }
  record.run_id = run.run_id;
  record.unit = run.unit;
  if (auto added = catalog.add_void(record); !added) return base::forward_error(added);
  return VoidedPart{run, std::move(record), withdrawn, segments->size()};
}

nlohmann::json voided_part_json(const VoidedPart& made) {
  nlohmann::json document = stored_void_json(made.record);
  document["run"] = made.run.label;
  document["run_id"] = made.run.run_id;
  document["segments_withdrawn"] = made.withdrawn;
  document["segments_before"] = made.counted;
  return document;
}

}  // namespace soak::station
