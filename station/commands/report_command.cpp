// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/unit_type_file.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/report/page.h"
#include "station/report/report.h"

namespace soak::station {
namespace {

/// soak report --unit SN -o FILE.html: a unit that exceeds its limits has its page all the same; the status is then
/// that of `limits`.
struct ReportCommand final : Command {
  std::string unit;
  std::string file;
  std::optional<int> model;  ///< version; absent = the newest
  std::string limits;        ///< path; empty = those of the unit's type

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit").required();
    options.add("-o,--output FILE", &file, "File to write").required();
    options.add("--model V", &model, "Model version (default: the newest)");
    options.add("--limits FILE", &limits,
                "Limits per sensor, applied to fresh runs (TOML; default: those of the unit's type); without limits "
                "the verdict is 'info'");
  }
  base::Status run(Output& output) override;
};

base::Result<nlohmann::json> make_report(const ReportCommand& command, Output& output) {
  ReportRequest request;
  request.unit = command.unit;
  request.model = command.model;
  request.created_utc_s = now_utc_s();
  request.software = "soak " + software_version();
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

void print_summary(const nlohmann::json& document, const ReportCommand& command, Output& output) {
  const nlohmann::json& summary = document["sections"]["summary"];
  output.print(fmt::format("{}: unit {}, model {}, {} bytes{}\n{}: {}\n", command.file, command.unit,
                           document["model"].get<int>(), document["bytes"].get<std::size_t>(),
                           summary["simulated"].get<bool>() ? ", SIMULATED" : "", summary["verdict"].get<std::string>(),
                           summary["sentence"].get<std::string>()));
}

base::Status ReportCommand::run(Output& output) {
  auto document = make_report(*this, output);
  if (!document) return base::forward_error(document);
  const std::string page = report_page(*document);
  if (const auto written = write_text_file(file, page); !written) return written;

  base::Sha256 hash;
  hash.update(page);
  (*document)["file"] = std::filesystem::absolute(file).string();
  (*document)["bytes"] = page.size();
  (*document)["sha256"] = base::to_hex(hash.finish());
  if (output.json()) {
    if (const auto printed = output.print_json(*document); !printed) return printed;
  } else {
    print_summary(*document, *this, output);
  }
  if ((*document)["sections"]["summary"]["verdict"] == "fail") {
    return base::fail(base::ErrorKind::limits, "the unit exceeds its limits", unit);
  }
  return {};
}

}  // namespace

CommandGroup report_commands() {
  return {"",
          "",
          {{"report", "Write one HTML page with all results of a unit",
            "soak report --unit SN0042 -o SN0042.html --limits limits.toml", std::make_shared<ReportCommand>()}}};
}

}  // namespace soak::station
