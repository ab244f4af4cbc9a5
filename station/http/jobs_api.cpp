// SPDX-License-Identifier: Apache-2.0
#include "station/http/jobs_api.h"

#include <nlohmann/json.hpp>

#include "base/text.h"
#include "station/http/members.h"
#include "station/io/text.h"
#include "station/report/unit_overview.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

/// Whether a job worked on the model as it is now. A number alone may come again: a catalog that was restored from a
/// backup counts on from there.
bool is_of_model(const json& job, const json& model) {
  return !model.is_null() && job.value("/result/model"_json_pointer, json()) == model["version"] &&
         job.value("started_utc_s", 0.0) >= model["created_utc_s"].get<double>();
}

/// Why the newest verdict on a unit does not hold for it as it is now; null where it does.
Result<json> why_stale(const db::Catalog& catalog, const json& job, const json& unit) {
  if (!is_of_model(job, unit["model"])) return json("the unit was fitted again since");
  if (unit["model"]["epoch"] != unit["epoch"]) return json("the unit was repaired or changed since");
  const auto withdrawn =
      withdrawn_since_start(catalog, job["unit"], job.value("campaign", ""), job.value("started_utc_s", 0.0));
  if (!withdrawn) return base::forward_error(withdrawn);
  if (*withdrawn) return json("data of its campaign were withdrawn since");
  const auto doubt = doubt_of_model(catalog, job["unit"]);
  if (!doubt) return base::forward_error(doubt);
  return doubt->empty() ? json() : json(*doubt);
}

/// The newest verdict on a unit, with why it does not hold, if it does not.
Result<json> verification_part(const db::Catalog& catalog, const json& job, const json& unit) {
  if (job.is_null()) return json();
  auto stale = why_stale(catalog, job, unit);
  if (!stale) return stale;
  return json{{"job", job}, {"stale", *std::move(stale)}};
}

/// The newest export of the model as it is now.
json export_part(const json& job, const json& model) {
  return !job.is_null() && is_of_model(job, model) ? job : json();
}

Result<json> answer_units(RunArchive& runs, const JobRunner& jobs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    auto list = units_overview(catalog);
    if (!list) return list;
    for (json& unit : (*list)["units"]) {
      auto part = verification_part(catalog, jobs.newest(unit["unit"], "verify"), unit);
      if (!part) return part;
      const bool holds = part->is_object() && (*part)["stale"].is_null();
      unit["verdict"] = holds ? (*part)["job"]["result"].value("verdict", json()) : json();
    }
    return list;
  });
}

Result<json> answer_unit(RunArchive& runs, const JobRunner& jobs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"unit"}); !known) return base::forward_error(known);
  const auto serial = required(parameters, "unit", "a serial number");
  if (!serial) return base::forward_error(serial);
  return runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    auto unit = unit_overview(catalog, *serial);
    if (!unit) return unit;
    auto part = verification_part(catalog, jobs.newest(*serial, "verify"), *unit);
    if (!part) return part;
    (*unit)["verification"] = *std::move(part);
    (*unit)["exported"] = export_part(jobs.newest(*serial, "export"), (*unit)["model"]);
    return unit;
  });
}

Result<std::int64_t> job_id(const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"id"}); !known) return base::forward_error(known);
  const auto text = required(parameters, "id", "the number of a job");
  if (!text) return base::forward_error(text);
  const auto id = base::parse_int(*text);
  if (!id) return base::bad_input("not the number of a job", "id");
  return *id;
}

Result<json> answer_jobs(RunArchive&, const JobRunner& jobs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return jobs.list();
}

Result<json> answer_job(RunArchive&, const JobRunner& jobs, const Parameters& parameters) {
  const auto id = job_id(parameters);
  if (!id) return base::forward_error(id);
  return jobs.show(*id);
}

/// Serial numbers and campaigns that were taken in may be any line of text, however long.
Result<std::string> name_member(const json& body, const std::string& name,
                                const std::optional<std::string>& otherwise) {
  auto text = text_member(body, name, otherwise);
  if (!text) return text;
  if (auto plain = check_text_line(*text, name); !plain && *text != otherwise) return base::forward_error(plain);
  return text;
}

Result<json> do_start(JobRunner& jobs, const json& body) {
  const auto known = only_members(body, {"kind", "unit", "campaign", "format", "simulated", "user"});
  if (!known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  const auto kind = line_member(body, "kind", std::nullopt);
  if (!kind) return base::forward_error(kind);
  const auto unit = name_member(body, "unit", std::nullopt);
  if (!unit) return base::forward_error(unit);
  const auto campaign = name_member(body, "campaign", "");
  if (!campaign) return base::forward_error(campaign);
  const auto format = name_member(body, "format", "");
  if (!format) return base::forward_error(format);
  const json simulated = body.value("simulated", json(false));
  if (!simulated.is_boolean()) return base::bad_input("the member is neither true nor false", "simulated");
  return jobs.start({*kind, *unit, *campaign, *format, simulated, *user});
}

Result<json> do_cancel(JobRunner& jobs, const json& body) {
  if (auto known = only_members(body, {"id", "user"}); !known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  const auto id = body.find("id");
  if (id == body.end() || !id->is_number_integer()) {
    return base::bad_input("the number of the job is missing or not a whole number", "id");
  }
  return jobs.cancel(id->get<std::int64_t>(), *user);
}

}  // namespace

const std::vector<JobQuestion>& job_questions() {
  static const std::vector<JobQuestion> questions = {
      {"units", answer_units}, {"unit", answer_unit}, {"jobs", answer_jobs}, {"job", answer_job}};
  return questions;
}

const std::vector<JobOrder>& job_orders() {
  static const std::vector<JobOrder> orders = {{"jobs", do_start}, {"jobs/cancel", do_cancel}};
  return orders;
}

Result<JobRunner::MadeFile> job_file(const JobRunner& jobs, const Parameters& parameters) {
  const auto id = job_id(parameters);
  if (!id) return base::forward_error(id);
  return jobs.file(*id);
}

}  // namespace soak::station
