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
#include "station/report/campaign_report.h"
#include "station/report/page.h"
#include "station/report/report.h"

namespace soak::station {
namespace {

/// soak report --unit SN | --campaign NAME, -o FILE.html: a unit that exceeds its limits has its page all the same; the
/// status is then that of `limits`.
struct ReportCommand final : Command {
  std::string unit;
  std::string campaign;
  std::string file;
  std::optional<int> model;  ///< version; absent = the newest
  std::string limits;        ///< path; empty = those of the unit's type

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit");
    options.add("--campaign NAME", &campaign, "All units of this campaign instead: an overview, then a page for each");
    options.add("-o,--output FILE", &file, "File to write").required();
    options.add("--model V", &model, "Model version, of --unit (default: the newest)");
    options.add("--limits FILE", &limits,
                "Limits per sensor, applied to fresh runs (TOML; default: those of the unit's type); without limits "
                "the verdict is 'info'");
  }
  base::Status run(Output& output) override;

 private:
  [[nodiscard]] base::Status check_options() const;
  [[nodiscard]] base::Result<ReportRequest> make_request(Output& output) const;
  base::Status run_unit(const db::Catalog& catalog, const ReportRequest& request, Output& output) const;
  base::Status run_campaign(const db::Catalog& catalog, const ReportRequest& request, Output& output) const;
  [[nodiscard]] base::Status write(const std::string& page, nlohmann::json& document) const;
};

base::Status ReportCommand::check_options() const {
  if (unit.empty() == campaign.empty()) {
    return base::bad_input("give --unit SN for one unit or --campaign NAME for all units of a campaign", "--unit");
  }
  if (model && unit.empty()) {
    return base::bad_input("the units of a campaign have a newest model each; --model goes with --unit", "--model");
  }
  return {};
}

base::Result<ReportRequest> ReportCommand::make_request(Output& output) const {
  ReportRequest request;
  request.unit = unit;
  request.model = model;
  request.created_utc_s = now_utc_s();
  request.software = "soak " + software_version();
  request.progress = output.progress("report");
  if (!limits.empty()) {
    const auto read = read_limits(limits);
    if (!read) return base::forward_error(read);
    request.limits = *read;
    request.limits_source = limits;
  }
  return request;
}

/// Adds to the document what is known of the file.
base::Status ReportCommand::write(const std::string& page, nlohmann::json& document) const {
  if (const auto written = write_text_file(file, page); !written) return written;
  base::Sha256 hash;
  hash.update(page);
  document["file"] = std::filesystem::absolute(file).string();
  document["bytes"] = page.size();
  document["sha256"] = base::to_hex(hash.finish());
  return {};
}

base::Status ReportCommand::run_unit(const db::Catalog& catalog, const ReportRequest& request, Output& output) const {
  auto document = report_document(catalog, request);
  output.end_progress();
  if (!document) return base::forward_error(document);
  if (auto written = write(report_page(*document), *document); !written) return written;
  const nlohmann::json& summary = (*document)["sections"]["summary"];
  if (output.json()) {
    if (const auto printed = output.print_json(*document); !printed) return printed;
  } else {
    output.print(fmt::format("{}: unit {}, model {}, {} bytes{}\n{}: {}\n", file, unit, (*document)["model"].get<int>(),
                             (*document)["bytes"].get<std::size_t>(),
                             summary["simulated"].get<bool>() ? ", SIMULATED" : "",
                             summary["verdict"].get<std::string>(), summary["sentence"].get<std::string>()));
  }
  if (summary["verdict"] != "fail") return {};
  return base::fail(base::ErrorKind::limits, "the unit exceeds its limits", unit);
}

base::Status ReportCommand::run_campaign(const db::Catalog& catalog, const ReportRequest& request,
                                         Output& output) const {
  auto report = campaign_report(catalog, campaign, request);
  output.end_progress();
  if (!report) return base::forward_error(report);
  if (auto written = write(campaign_page(*report), report->document); !written) return written;
  std::string lines;
  std::size_t failed = 0;
  const nlohmann::json& units = report->document["units"];
  for (const nlohmann::json& line : units) {
    const bool has_report = line["trouble"].is_null();
    lines += fmt::format("{}: {}{}\n", line["unit"].get<std::string>(),
                         has_report ? line["verdict"].get<std::string>() + ": " : "no report: ",
                         line[has_report ? "sentence" : "trouble"].get<std::string>());
    failed += line["verdict"] == "fail" ? 1 : 0;
  }
  if (output.json()) {
    if (const auto printed = output.print_json(report->document); !printed) return printed;
  } else {
    output.print(fmt::format("{}: campaign {}, {} units, {} bytes\n{}", file, campaign, units.size(),
                             report->document["bytes"].get<std::size_t>(), lines));
  }
  if (failed == 0) return {};
  return base::fail(base::ErrorKind::limits, fmt::format("{} of {} units exceed their limits", failed, units.size()),
                    campaign);
}

base::Status ReportCommand::run(Output& output) {
  if (auto checked = check_options(); !checked) return checked;
  const auto request = make_request(output);
  if (!request) return base::forward_error(request);
  const auto catalog = open_existing_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  return unit.empty() ? run_campaign(*catalog, *request, output) : run_unit(*catalog, *request, output);
}

}  // namespace

CommandGroup report_commands() {
  return {"",
          "",
          {{"report", "Write one HTML page with all results of a unit, or of a campaign",
            "soak report --unit SN0042 -o SN0042.html --limits limits.toml", std::make_shared<ReportCommand>()}}};
}

}  // namespace soak::station
