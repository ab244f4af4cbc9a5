// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "base/text.h"
#include "calib/vocabulary/sensor.h"
#include "db/run/run_file.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/runs/run_document.h"
#include "station/runs/run_streams.h"

namespace soak::station {
namespace {

/// soak runs list
struct RunsList final : CatalogCommand {
  db::RunFilter filter;

  void declare(OptionList& options) override {
    options.add("--unit SN", &filter.unit, "Only runs of this unit");
    options.add("--campaign NAME", &filter.campaign, "Only runs of this campaign");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak runs show RUN
struct RunsShow final : CatalogCommand {
  db::RunFilter filter;

  void declare(OptionList& options) override { declare_run(options, filter); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

std::string run_state(const db::RunRow& run) {
  std::string text = run.sealed ? "sealed" : "open";
  if (run.voided) text += ", void";
  if (!run.cut_short.empty()) text += ", cut short";
  if (run.samples_dropped) text += ", samples dropped";
  if (!run.continues.empty()) text += ", goes on from " + run.continues.substr(0, 13);
  if (run.simulated) text += ", SIMULATED";
  return text;
}

base::Status RunsList::run_with(db::Catalog& catalog, Output& output) {
  const auto runs = catalog.runs(filter);
  if (!runs) return base::forward_error(runs);
  if (output.json()) {
    nlohmann::json list = nlohmann::json::array();
    for (const db::RunRow& row : *runs) list.push_back(stored_run_json(row));
    return output.print_json({{"runs", list}});
  }
  std::vector<std::vector<std::string>> table = {
      {"unit", "campaign", "run", "purpose", "run id", "rows", "seconds", "state"}};
  for (const db::RunRow& row : *runs) {
    table.push_back({row.unit, row.campaign, row.label, row.purpose, row.run_id, std::to_string(row.rows),
                     fmt::format("{:.1f}", row.duration_s), run_state(row)});
  }
  output.print(text_table(table));
  return {};
}

std::string run_header_text(const db::RunRow& run, const std::string& source) {
  const auto site = [](const std::optional<double>& value) { return value ? fmt::format("{}", *value) : "unknown"; };
  return fmt::format(
      "run        {} ({})\nunit       {}, epoch {}\ncampaign   {}, procedure {}\npurpose    {}\nsource     {}\n"
      "rows       {} in {:.1f} s\nstate      {}\n"
      "site       latitude {} deg, height {} m, azimuth {} deg, gravity {} m/s2\n"
      "content    {}\nfile       {} (sha256 {})\n",
      run.label, run.run_id, run.unit, run.epoch, run.campaign, run.procedure, run.purpose, source, run.rows,
      run.duration_s, run_state(run), site(run.site.latitude_deg), site(run.site.height_m), site(run.site.azimuth_deg),
      site(run.site.gravity_mps2), run.content_sha256, run.file_name, run.file_sha256);
}

std::string channel_table(const std::vector<db::ChannelInfo>& channels) {
  std::vector<std::vector<std::string>> table = {{"channel", "name in source", "type", "unit", "scale", "offset"}};
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

std::string drop_text(const std::optional<db::SampleDrop>& drop) {
  if (!drop) return "";
  return fmt::format("samples dropped on {} by {}: {}\n", base::utc_text(drop->utc_s), drop->user, drop->reason);
}

/// What the run file says besides the samples themselves.
struct FileFacts {
  std::string source;
  std::vector<db::ChannelInfo> channels;  ///< of the unit; none where the samples were dropped
};

base::Result<FileFacts> file_facts(const db::Catalog& catalog, const db::RunRow& run) {
  if (run.samples_dropped) return FileFacts{run.samples_dropped->source, {}};
  const auto file = catalog.open_run_file(run);
  if (!file) return base::forward_error(file);
  const auto stream = imu_stream(*file, run.unit);
  if (!stream) return base::forward_error(stream);
  return FileFacts{file->info().source, file->streams()[*stream].channels};
}

base::Status RunsShow::run_with(db::Catalog& catalog, Output& output) {
  const auto row = find_run(catalog, filter);
  if (!row) return base::forward_error(row);
  const auto facts = file_facts(catalog, *row);
  if (!facts) return base::forward_error(facts);
  const auto segments = catalog.segments(row->run_id, row->unit, false);
  if (!segments) return base::forward_error(segments);
  const auto voids = catalog.voids(row->run_id);
  if (!voids) return base::forward_error(voids);
  if (!output.json()) {
    const std::string channels = row->samples_dropped ? "" : channel_table(facts->channels) + "\n";
    output.print(run_header_text(*row, facts->source) + "\n" + channels + segment_table(*segments) +
                 finding_text(*segments) + void_text(*voids) + drop_text(row->samples_dropped));
    return {};
  }
  nlohmann::json document = {{"run", stored_run_json(*row)},
                             {"source", facts->source},
                             {"channels", nlohmann::json::array()},
                             {"segments", nlohmann::json::array()},
                             {"voids", nlohmann::json::array()}};
  for (const db::ChannelInfo& channel : facts->channels) document["channels"].push_back(stored_channel_json(channel));
  for (const calib::Segment& segment : *segments) document["segments"].push_back(stored_segment_json(segment));
  for (const db::VoidRecord& record : *voids) document["voids"].push_back(stored_void_json(record));
  return output.print_json(document);
}

}  // namespace

CommandGroup run_show_commands() {
  return {"runs",
          "Runs: list, show, export, void, verify, drop samples",
          {{"list", "List all runs", "soak runs list --unit SN0042 --json", std::make_shared<RunsList>()},
           {"show", "Show one run: channels, segments with their means, void records", "soak runs show soak_run_1",
            std::make_shared<RunsShow>()}}};
}

}  // namespace soak::station
