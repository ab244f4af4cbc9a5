// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/gate_rejections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "calib/estimate/unit_input.h"

namespace soak::calib::gap {
namespace {

constexpr std::size_t kMostInWords = 3;

const Finding* rejecting(const Segment& segment, std::optional<Sensor> sensor) {
  const auto found = std::find_if(segment.findings.begin(), segment.findings.end(), [&](const Finding& finding) {
    return finding.severity == Severity::reject && finding.sensor == sensor;
  });
  return found == segment.findings.end() ? nullptr : &*found;
}

void count(LeftOut& entry, const Segment& segment, std::optional<Sensor> sensor) {
  const Finding* finding = rejecting(segment, sensor);
  if (finding == nullptr) return;
  if (entry.segments++ > 0) return;
  entry.code = finding->code;
  entry.why = finding->text;
}

}  // namespace

std::vector<LeftOut> left_out_by_gate(const LoggedCampaign& campaign) {
  std::vector<LeftOut> all;
  for (const LoggedRun& logged : campaign.runs) {
    const RunInput& run = logged.run;
    LeftOut whole{.run = run.label, .sensor = {}, .segments = 0, .of = 0, .code = {}, .why = {}};
    std::array<LeftOut, kSensorCount> single;
    for (const Segment& segment : run.segments) {
      if (segment.phase != Phase::soak) continue;
      ++whole.of;
      count(whole, segment, std::nullopt);
      if (is_rejected(segment)) continue;
      for (const Sensor sensor : kSensors) count(single[index_of(sensor)], segment, sensor);
    }
    if (whole.segments > 0) all.push_back(whole);
    for (const Sensor sensor : kSensors) {
      LeftOut& entry = single[index_of(sensor)];
      if (entry.segments == 0) continue;
      entry.run = run.label;
      entry.sensor = sensor;
      entry.of = whole.of;
      all.push_back(std::move(entry));
    }
  }
  return all;
}

std::string in_words(const std::vector<LeftOut>& left_out) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostInWords, left_out.size()); ++i) {
    const LeftOut& entry = left_out[i];
    text += fmt::format("{}{}run {} in {} of {} segments ({})", text.empty() ? "" : ", ",
                        entry.sensor ? fmt::format("{} of ", name_of(*entry.sensor)) : "", entry.run, entry.segments,
                        entry.of, entry.code);
  }
  if (left_out.size() > kMostInWords) text += fmt::format(" and {} more", left_out.size() - kMostInWords);
  return text;
}

bool any_run_lost(const std::vector<LeftOut>& left_out) {
  return std::any_of(left_out.begin(), left_out.end(),
                     [](const LeftOut& entry) { return !entry.sensor && 2 * entry.segments > entry.of; });
}

}  // namespace soak::calib::gap
