// SPDX-License-Identifier: Apache-2.0
#include "station/runs/run_document.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "calib/vocabulary/sensor.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

json stated_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

template <class T>
json present_or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

json drop_json(const std::optional<db::SampleDrop>& drop) {
  if (!drop) return json();
  return {{"reason", drop->reason}, {"user", drop->user}, {"utc_s", drop->utc_s}, {"bytes", drop->bytes}};
}

json finding_json(const calib::Finding& finding) {
  return {{"code", finding.code},
          {"severity", calib::name_of(finding.severity)},
          {"sensor", finding.sensor ? json(calib::name_of(*finding.sensor)) : json()},
          {"text", finding.text}};
}

json sensors_json(const calib::Segment& segment) {
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const calib::SensorStatistics& statistics = segment.sensor[calib::index_of(sensor)];
    if (statistics.count == 0) continue;
    const double factor = calib::printed_per_si(sensor);
    sensors[std::string(calib::name_of(sensor))] = {{"mean", number_or_null(statistics.mean * factor)},
                                                    {"se", number_or_null(statistics.standard_error * factor)},
                                                    {"count", statistics.count},
                                                    {"unit", calib::printed_unit(sensor)}};
  }
  return sensors;
}

}  // namespace

json stored_run_json(const db::RunRow& run) {
  return {{"unit", run.unit},
          {"campaign", run.campaign},
          {"run", run.label},
          {"run_id", run.run_id},
          {"procedure", run.procedure},
          {"purpose", run.purpose},
          {"epoch", run.epoch},
          {"created_utc_s", run.created_utc_s},
          {"clock_rate", run.clock_rate},
          {"rows", run.rows},
          {"duration_s", run.duration_s},
          {"sealed", run.sealed},
          {"voided", run.voided},
          {"cut_short", stated_or_null(run.cut_short)},
          {"continues", stated_or_null(run.continues)},
          {"simulated", run.simulated},
          {"file", run.file_name},
          {"file_sha256", run.file_sha256},
          {"content_sha256", run.content_sha256},
          {"samples_dropped", drop_json(run.samples_dropped)},
          {"site",
           {{"latitude_deg", number_or_null(run.site.latitude_deg)},
            {"height_m", number_or_null(run.site.height_m)},
            {"azimuth_deg", number_or_null(run.site.azimuth_deg)},
            {"gravity_mps2", number_or_null(run.site.gravity_mps2)}}}};
}

json stored_channel_json(const db::ChannelInfo& channel) {
  return {{"name", channel.name},
          {"source_name", channel.source_name},
          {"type", db::name_of(channel.type)},
          {"unit", channel.unit},
          {"scale", channel.scale},
          {"offset", channel.offset},
          {"labels", channel.labels}};
}

json stored_segment_json(const calib::Segment& segment) {
  json findings = json::array();
  for (const calib::Finding& finding : segment.findings) findings.push_back(finding_json(finding));
  return {{"visit", segment.key.visit},
          {"position", segment.key.position},
          {"azimuth_deg", number_or_null(segment.position ? segment.position->azimuth_deg : std::nullopt)},
          {"attempt", segment.key.attempt},
          {"phase", segment.phase == calib::Phase::ramp ? "ramp" : "soak"},
          {"sweep", calib::name_of(segment.sweep)},
          {"plateau_c", number_or_null(segment.plateau_c)},
          {"t_start_s", segment.t_start_s},
          {"t_end_s", segment.t_end_s},
          {"temp_c", number_or_null(segment.temp_c)},
          {"temp_rate_kpmin", number_or_null(segment.temp_rate_kpmin)},
          {"sensors", sensors_json(segment)},
          {"findings", findings}};
}

json stored_void_json(const db::VoidRecord& record) {
  return {{"unit", record.unit},
          {"visit", present_or_null(record.visit)},
          {"position", present_or_null(record.position)},
          {"attempt", present_or_null(record.attempt)},
          {"reason", record.reason},
          {"user", record.user},
          {"utc_s", record.utc_s}};
}

}  // namespace soak::station
