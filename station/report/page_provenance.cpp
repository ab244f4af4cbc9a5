// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "station/report/html.h"
#include "station/report/page_parts.h"

namespace soak::station {
namespace {

using nlohmann::json;

std::string_view use_words(std::string_view use) {
  if (use == "fitted") return "fitted";
  if (use == "fresh") return "verification, in no fit";
  if (use == "not_used") return "not in this model";
  if (use == "diagnosis") return "diagnosis, never fitted";
  if (use == "voided") return "void";
  return "not sealed";
}

std::string recorded_text(const json& run) {
  std::string text = html::text_of(run, "source");
  if (run["clock_rate"] != 1.0) text += fmt::format(", clock rate {}", html::number(run["clock_rate"]));
  if (run["simulated"].get<bool>()) text += ", SIMULATED";
  return text;
}

std::string site_text(const json& run) {
  std::string text =
      fmt::format("{} m/s² ({})", html::number(run["gravity_mps2"].get<double>(), 5), html::text_of(run, "gravity"));
  if (run["latitude_deg"].is_number()) {
    text += fmt::format(", latitude {}°", html::number(run["latitude_deg"].get<double>(), 2));
  }
  return text;
}

std::string runs_table(const json& runs) {
  html::Table table("Runs of this unit in this epoch", {"run", "campaign", "procedure", "use", "stored", "length",
                                                        "how recorded", "gravity", "content hash (SHA-256)"});
  for (const json& run : runs) {
    const bool withdrawn = run["use"] == "fitted" && !run["voids"].empty() && run["voids"][0]["what"] == "run";
    table.row({html::row_heading(run["label"].get<std::string>()),
               html::html_cell(html::text_of(run, "campaign")),
               html::html_cell(html::text_of(run, "procedure")),
               html::text_cell(std::string(use_words(run["use"].get<std::string>())) + (withdrawn ? ", now void" : "")),
               {.html = html::date_time(run["created_utc_s"]), .style = "nowrap"},
               {.html = html::duration(run["duration_s"]), .style = "nowrap"},
               html::html_cell(recorded_text(run)),
               html::html_cell(site_text(run)),
               html::html_cell("<code>" + html::text_of(run, "content_sha256") + "</code>")});
  }
  return table.html();
}

std::string voids_table(const json& runs) {
  html::Table table("Withdrawn, with reason", {"run", "what", "reason", "by", "when"});
  bool any = false;
  for (const json& run : runs) {
    for (const json& entry : run["voids"]) {
      any = true;
      const bool whole = entry["what"] == "run";
      table.row(
          {html::row_heading(run["label"].get<std::string>()),
           html::text_cell(whole ? "the whole run" : fmt::format("{} records on parts", entry["records"].get<int>())),
           html::html_cell(html::text_of(entry, "reason")),
           html::html_cell(html::text_of(entry, "user")),
           {.html = html::date_time(entry["utc_s"]), .style = "nowrap"}});
    }
  }
  return any ? table.html() : "<p>Nothing of these runs is withdrawn.</p>\n";
}

}  // namespace

std::string provenance_part(const json& document) {
  const json& sections = document["sections"];
  const json& provenance = sections["provenance"];
  std::string html = "<section id=\"provenance\"><h2>Where it comes from</h2>\n";
  html += runs_table(provenance["runs"]) + voids_table(provenance["runs"]);
  html += html::facts({{"Model document (SHA-256)", "<code>" + html::text_of(provenance, "model_sha256") + "</code>"},
                       {"Fitted", html::date_time(sections["summary"]["model_created_utc_s"])},
                       {"Page made by", html::text_of(document, "software")},
                       {"Page made", html::date_time(document["created_utc_s"])}});
  html += fmt::format(
      "<p>What a shorter campaign would have given: <code>soak fit --unit {} --chamber-time</code>. Every "
      "byte of the runs is checked by <code>soak runs verify</code>.</p>\n",
      html::text_of(document, "unit"));
  return html + "</section>\n";
}

}  // namespace soak::station
