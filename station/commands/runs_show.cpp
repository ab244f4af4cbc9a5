// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "calib/vocabulary/sensor.h"
#include "db/run/run_file.h"
#include "station/commands/run_document.h"
#include "station/commands/runs_command.h"
#include "station/io/data_folder.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

nlohmann::json channel_document(const db::ChannelInfo& channel) {
  return {{"name", channel.name},
          {"source_name", channel.source_name},
          {"type", db::name_of(channel.type)},
          {"unit", channel.unit},
          {"scale", channel.scale},
          {"offset", channel.offset},
          {"labels", channel.labels}};
}

nlohmann::json finding_document(const calib::Finding& finding) {
  return {{"code", finding.code},
          {"severity", calib::name_of(finding.severity)},
          {"sensor", finding.sensor ? nlohmann::json(calib::name_of(*finding.sensor)) : nlohmann::json()},
          {"text", finding.text}};
}

nlohmann::json segment_document(const calib::Segment& segment) {
  nlohmann::json sensors = nlohmann::json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const calib::SensorStatistics& statistics = segment.sensor[calib::index_of(sensor)];
    if (statistics.count == 0) continue;
    const double factor = calib::printed_per_si(sensor);
    sensors[std::string(calib::name_of(sensor))] = {{"mean", number_or_null(statistics.mean * factor)},
                                                    {"se", number_or_null(statistics.standard_error * factor)},
                                                    {"count", statistics.count},
                                                    {"unit", calib::printed_unit(sensor)}};
  }
  nlohmann::json findings = nlohmann::json::array();
  for (const calib::Finding& finding : segment.findings) findings.push_back(finding_document(finding));
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
          {"sensors", sensors},
          {"findings", findings}};
}

template <class T>
nlohmann::json value_or_null(const std::optional<T>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

nlohmann::json void_document(const db::VoidRecord& record) {
  return {{"unit", record.unit},
          {"visit", value_or_null(record.visit)},
          {"position", value_or_null(record.position)},
          {"attempt", value_or_null(record.attempt)},
          {"reason", record.reason},
          {"user", record.user},
          {"utc_s", record.utc_s}};
}

std::string header_text(const db::RunRow& run, const db::RunInfo& info) {
  const auto site = [](const std::optional<double>& value) { return value ? fmt::format("{}", *value) : "unknown"; };
  return fmt::format(
      "run        {} ({})\nunit       {}, epoch {}\ncampaign   {}, procedure {}\npurpose    {}\nsource     {}\n"
      "rows       {} in {:.1f} s\nstate      {}{}{}\n"
      "site       latitude {} deg, height {} m, azimuth {} deg, gravity {} m/s2\n"
      "content    {}\nfile       {} (sha256 {})\n",
      run.label, run.run_id, run.unit, run.epoch, run.campaign, run.procedure, run.purpose, info.source, run.rows,
      run.duration_s, run.sealed ? "sealed" : "open", run.voided ? ", void" : "", run.simulated ? ", SIMULATED" : "",
      site(run.site.latitude_deg), site(run.site.height_m), site(run.site.azimuth_deg), site(run.site.gravity_mps2),
      run.content_sha256, run.file_name, run.file_sha256);
}

std::string channel_table(const std::vector<db::ChannelInfo>& channels) {
  std::vector<std::vector<std::string>> table = {{"channel", "source's name", "type", "unit", "scale", "offset"}};
  for (const db::ChannelInfo& channel : channels) {
    table.push_back({channel.name, channel.source_name, std::string(db::name_of(channel.type)), channel.unit,
                     fmt::format("{}", channel.scale), fmt::format("{}", channel.offset)});
  }
  return text_table(table);
}

std::string segment_table(const std::vector<calib::Segment>& segments) {
  std::vector<std::vector<std::string>> table = {
      {"visit", "position", "attempt", "sweep", "plateau", "temp C", "from s", "to s"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    table.front().push_back(fmt::format("{} {}", calib::name_of(sensor), calib::printed_unit(sensor)));
  }
  for (const calib::Segment& segment : segments) {
    auto& row = table.emplace_back();
    row = {std::to_string(segment.key.visit),
           segment.key.position.empty() ? "-" : segment.key.position,
           std::to_string(segment.key.attempt),
           std::string(calib::name_of(segment.sweep)),
           segment.plateau_c ? fmt::format("{:g}", *segment.plateau_c) : "-",
           fmt::format("{:.3f}", segment.temp_c),
           fmt::format("{:.1f}", segment.t_start_s),
           fmt::format("{:.1f}", segment.t_end_s)};
    for (const calib::Sensor sensor : calib::kSensors) {
      const calib::SensorStatistics& statistics = segment.sensor[calib::index_of(sensor)];
      const double factor = calib::printed_per_si(sensor);
      row.push_back(statistics.count == 0
                        ? "-"
                        : fmt::format("{:.6f} ± {:.6f}", statistics.mean * factor, statistics.standard_error * factor));
    }
  }
  return text_table(table);
}

std::string finding_text(const std::vector<calib::Segment>& segments) {
  std::string text;
  for (const calib::Segment& segment : segments) {
    for (const calib::Finding& finding : segment.findings) {
      text += fmt::format("{}: visit {}, position {}, attempt {}: {}: {}\n", calib::name_of(finding.severity),
                          segment.key.visit, segment.key.position.empty() ? "-" : segment.key.position,
                          segment.key.attempt, finding.code, finding.text);
    }
  }
  return text;
}

std::string void_text(const std::vector<db::VoidRecord>& voids) {
  std::string text;
  for (const db::VoidRecord& record : voids) {
    text += fmt::format("void: {}{}{} by {}: {}\n",
                        record.visit ? fmt::format("visit {}", *record.visit) : std::string("the whole run"),
                        record.position ? fmt::format(", position {}", *record.position) : "",
                        record.attempt ? fmt::format(", attempt {}", *record.attempt) : "", record.user, record.reason);
  }
  return text;
}

}  // namespace

base::Status run_runs_show(const RunsShowCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto run = find_run(*catalog, command.filter);
  if (!run) return base::forward_error(run);
  const auto file = db::RunFileReader::open(catalog->run_file_path(*run));
  if (!file) return base::forward_error(file);
  const auto stream = imu_stream(*file, run->unit);
  if (!stream) return base::forward_error(stream);
  const auto segments = catalog->segments(run->run_id, run->unit, false);
  if (!segments) return base::forward_error(segments);
  const auto voids = catalog->voids(run->run_id);
  if (!voids) return base::forward_error(voids);
  const auto& channels = file->streams()[*stream].channels;

  if (!output.json()) {
    output.print(header_text(*run, file->info()) + "\n" + channel_table(channels) + "\n" + segment_table(*segments) +
                 finding_text(*segments) + void_text(*voids));
    return {};
  }
  nlohmann::json document = {{"run", run_document(*run)},
                             {"source", file->info().source},
                             {"channels", nlohmann::json::array()},
                             {"segments", nlohmann::json::array()},
                             {"voids", nlohmann::json::array()}};
  for (const db::ChannelInfo& channel : channels) document["channels"].push_back(channel_document(channel));
  for (const calib::Segment& segment : *segments) document["segments"].push_back(segment_document(segment));
  for (const db::VoidRecord& record : *voids) document["voids"].push_back(void_document(record));
  return output.print_json(document);
}

}  // namespace soak::station
