// SPDX-License-Identifier: Apache-2.0
#include "station/commands/report_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "station/config/limits_file.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/report/page.h"
#include "station/report/report.h"

namespace soak::station {
namespace {

base::Result<nlohmann::json> make_document(const ReportCommand& command, Output& output) {
  ReportRequest request;
  request.unit = command.unit;
  request.model = command.model;
  request.created_utc_s = now_utc_s();
  request.software = command.software;
  request.progress = output.progress("report");
  if (!command.limits.empty()) {
    const auto limits = read_limits(command.limits);
    if (!limits) return base::forward_error(limits);
    request.limits = *limits;
    request.limits_source = command.limits;
  }
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  auto document = report_document(*catalog, request);
  output.end_progress();
  return document;
}

void describe(const nlohmann::json& document, const ReportCommand& command, Output& output) {
  const nlohmann::json& summary = document["sections"]["summary"];
  output.print(fmt::format("{}: unit {}, model {}, {} bytes{}\n{}: {}\n", command.file, command.unit,
                           document["model"].get<int>(), document["bytes"].get<std::size_t>(),
                           summary["simulated"].get<bool>() ? ", SIMULATED" : "", summary["verdict"].get<std::string>(),
                           summary["sentence"].get<std::string>()));
}

}  // namespace

base::Status run_report(const ReportCommand& command, Output& output) {
  auto document = make_document(command, output);
  if (!document) return base::forward_error(document);
  const std::string page = report_page(*document);
  if (const auto written = write_text_file(command.file, page); !written) return written;

  base::Sha256 hash;
  hash.update(page);
  (*document)["file"] = std::filesystem::absolute(command.file).string();
  (*document)["bytes"] = page.size();
  (*document)["sha256"] = base::to_hex(hash.finish());
  if (output.json()) {
    if (const auto printed = output.print_json(*document); !printed) return printed;
  } else {
    describe(*document, command, output);
  }
  if ((*document)["sections"]["summary"]["verdict"] == "fail") {
    return base::fail(base::ErrorKind::limits, "the unit fails its limits", command.unit);
  }
  return {};
}

}  // namespace soak::station
