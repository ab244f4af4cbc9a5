// SPDX-License-Identifier: Apache-2.0
#include "station/http/jobs_api.h"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "calib/judge/warning_list.h"
#include "station/fit/fit_unit.h"
#include "station/http/members.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/release/release_rule.h"
#include "station/report/fleet_overview.h"
#include "station/report/unit_overview.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

constexpr std::size_t kMostEffects = 20;  // the library has no more

/// Whether a job worked on the model as it is now. A number alone may come again: a catalog that was restored from a
/// backup counts on from there.
bool is_of_model(const json& job, const json& model) {
  return !model.is_null() && job.value("/result/model"_json_pointer, json()) == model["version"] &&
         job.value("started_utc_s", 0.0) >= model["created_utc_s"].get<double>();
}

/// Why what a job said of a unit does not hold for it as it is now; null where it does. One without a campaign is of
/// all runs.
Result<json> why_stale(const db::Catalog& catalog, const json& job, const json& unit) {
  if (!is_of_model(job, unit["model"])) return json("the unit was fitted again since");
  if (unit["model"]["epoch"] != unit["epoch"]) return json("the unit was repaired or changed since");
  const auto head = model_head(catalog, job["unit"], unit["model"]["version"]);
  if (!head) return base::forward_error(head);
  if (head->state == "withdrawn") return json("the model was withdrawn since");
  std::optional<std::string> campaign;
  if (job["campaign"].is_string()) campaign = job["campaign"];
  const auto withdrawn = withdrawn_since_start(catalog, job["unit"], campaign, job.value("started_utc_s", 0.0));
  if (!withdrawn) return base::forward_error(withdrawn);
  if (*withdrawn) return json(campaign ? "data of its campaign were withdrawn since" : "data were withdrawn since");
  const auto doubt = doubt_of_model(catalog, job["unit"]);
  if (!doubt) return base::forward_error(doubt);
  return doubt->empty() ? json() : json(*doubt);
}

/// A job with why what it said does not hold, if it does not; null where there is no job.
Result<json> kept_part(const db::Catalog& catalog, const json& job, const json& unit) {
  if (job.is_null()) return json();
  auto stale = why_stale(catalog, job, unit);
  if (!stale) return stale;
  return json{{"job", job}, {"stale", *std::move(stale)}};
}

/// What a verification that holds warns of, with what to do.
json warnings_of(const json& part) {
  calib::WarningList warnings;
  const json stored = part["job"]["result"].value("warnings", json::array());
  if (part["stale"].is_null() && stored.is_array()) warnings.add_stored(stored);
  return warnings.take();
}

/// The newest verification of a unit; null where there is none.
Result<json> verification_part(const db::Catalog& catalog, const json& job, const json& unit) {
  auto part = kept_part(catalog, job, unit);
  if (part && part->is_object()) (*part)["warnings"] = warnings_of(*part);
  return part;
}

/// The newest search or comparison of a unit's gap. It holds until runs come that it would have looked at.
Result<json> gap_part(const db::Catalog& catalog, const json& job, const json& unit) {
  auto part = kept_part(catalog, job, unit);
  if (!part || !part->is_object() || !(*part)["stale"].is_null()) return part;
  const bool only_fitted = job["kind"] == "gap_find";
  const auto recorded = recorded_since(catalog, job["unit"], job.value("started_utc_s", 0.0), only_fitted);
  if (!recorded) return base::forward_error(recorded);
  if (*recorded) (*part)["stale"] = "runs were added since";
  return part;
}

/// The newest export of the model as it is now.
json export_part(const json& job, const json& model) {
  return !job.is_null() && is_of_model(job, model) ? job : json();
}

/// What the rule of release says of the newest model now; null where there is no model. That records are damaged is in
/// the way of a release, too.
Result<json> release_part(const db::Catalog& catalog, const json& unit) {
  if (unit["model"].is_null()) return json();
  const auto head = model_head(catalog, unit["unit"], unit["model"]["version"]);
  if (!head) return base::forward_error(head);
  const auto release = judge_release(catalog, *head, now_utc_s());
  if (!release && release.error().kind != base::ErrorKind::corrupt) return base::forward_error(release);
  if (!release) return json{{"obstacles", {release.error().message}}, {"expires", nullptr}};
  return json{{"obstacles", release->obstacles},
              {"expires", release->expires_utc_s ? json(iso_date(*release->expires_utc_s)) : json()}};
}

/// The newest verification of a unit; null where there is none. `newest`: those of all units.
json newest_of(const std::map<std::string, json>& newest, const json& unit) {
  const auto own = newest.find(unit["unit"].get<std::string>());
  return own == newest.end() ? json() : own->second;
}

/// The verdict that holds for a unit, of its newest verification; null where there is none.
Result<json> verdict_of(const db::Catalog& catalog, const json& job, const json& unit) {
  auto part = kept_part(catalog, job, unit);
  if (!part) return part;
  const bool holds = part->is_object() && (*part)["stale"].is_null();
  return holds ? (*part)["job"]["result"].value("verdict", json()) : json();
}

/// As release_part(), of a model that is released or might be; null for others. A model that this program cannot read
/// does not keep the others from being listed.
json release_of_listed(const db::Catalog& catalog, const json& unit) {
  const std::string state = unit.value("/model/state"_json_pointer, "");
  if (state != "verified" && state != "released") return json();
  auto release = release_part(catalog, unit);
  if (!release) return json{{"obstacles", {release.error().message}}, {"expires", nullptr}};
  return *std::move(release);
}

/// Whether the newest model carries effects: what it lacks was searched for then.
bool carries_effects(const db::Catalog& catalog, const json& unit) {
  const auto terms = accepted_terms(catalog, unit["unit"], unit["epoch"]);
  return terms && !terms->empty();
}

/// Whether a search for what the newest model lacks is kept.
bool search_is_kept(const JobRunner& jobs, const json& unit) {
  const json search = jobs.newest(unit["unit"], "gap_find");
  return search.is_object() && is_of_model(search, unit["model"]);
}

/// What reads the newest model of a unit: its verdict and what the release rule says, and whether it carries effects.
Result<json> read_of_listed(const db::Catalog& catalog, const json& job, const json& unit) {
  auto verdict = verdict_of(catalog, job, unit);
  if (!verdict) return verdict;
  return json{{"verdict", *std::move(verdict)},
              {"release", release_of_listed(catalog, unit)},
              {"gap_searched", carries_effects(catalog, unit)}};
}

Result<json> answer_units(RunArchive& runs, const JobRunner& jobs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {}); !known) return base::forward_error(known);
  return runs.in_turn([&](const db::Catalog& catalog) -> Result<json> {
    WorkedOut& known = runs.worked_out();
    if (auto renewed = known.renew(catalog, iso_date(now_utc_s())); !renewed) return base::forward_error(renewed);
    auto list = known.of_all([&] { return units_overview(catalog); });
    if (!list) return list;
    const auto newest = jobs.newest_verdicts();
    for (json& unit : (*list)["units"]) {
      const json job = newest_of(newest, unit);
      const auto read = known.of(unit["unit"], job, [&] { return read_of_listed(catalog, job, unit); });
      if (!read) return read;
      unit.update(*read);
      if (unit["gap_searched"] == false) unit["gap_searched"] = search_is_kept(jobs, unit);
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
    auto found = gap_part(catalog, jobs.newest(*serial, "gap_find"), *unit);
    if (!found) return found;
    auto shown = gap_part(catalog, jobs.newest(*serial, "gap_show"), *unit);
    if (!shown) return shown;
    (*unit)["gap"] = {{"find", *std::move(found)}, {"show", *std::move(shown)}};
    auto release = release_part(catalog, *unit);
    if (!release) return release;
    (*unit)["release"] = *std::move(release);
    (*unit)["exported"] = export_part(jobs.newest(*serial, "export"), (*unit)["model"]);
    return unit;
  });
}

Result<json> answer_fleet(RunArchive& runs, const JobRunner& jobs, const Parameters& parameters) {
  if (auto known = only_parameters(parameters, {"type"}); !known) return base::forward_error(known);
  const auto type = required(parameters, "type", "a type of units, as /api/v1/units gives it");
  if (!type) return base::forward_error(type);
  const auto newest = jobs.newest_verdicts();
  return fleet_overview(
      {.in_turn = [&](const FleetSources::Work& work) { return runs.in_turn(work); },
       .verdict = [&](const db::Catalog& catalog,
                      const json& unit) { return verdict_of(catalog, newest_of(newest, unit), unit); }},
      *type);
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

/// Names of effects; none where the member is absent.
Result<std::vector<std::string>> effects_member(const json& body) {
  std::vector<std::string> effects;
  const json member = body.value("effects", json::array());
  if (!member.is_array() || member.size() > kMostEffects) {
    return base::bad_input(fmt::format("the member is not a list of at most {} names", kMostEffects), "effects");
  }
  for (const json& name : member) {
    if (!name.is_string() || name.get_ref<const std::string&>().empty()) {
      return base::bad_input("a name of the list is not text, or is empty", "effects");
    }
    effects.push_back(name);
    if (auto plain = check_single_line(effects.back(), "effects"); !plain) return base::forward_error(plain);
  }
  return effects;
}

/// A whole number from 1 on; none where the member is absent.
Result<std::optional<std::int32_t>> counted_member(const json& body, const std::string& name) {
  const auto found = body.find(name);
  if (found == body.end()) return std::nullopt;
  const bool is_one = found->is_number_integer() && *found >= 1 && *found <= std::numeric_limits<std::int32_t>::max();
  if (!is_one) return base::bad_input("the member is no whole number from 1 to 2147483647", name);
  return found->get<std::int32_t>();
}

Result<json> do_start(JobRunner& jobs, const json& body) {
  const auto known = only_members(body, {"kind", "unit", "campaign", "format", "model", "simulated", "sign", "effects",
                                         "accel_id", "gyro_id", "user"});
  if (!known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  const auto kind = line_member(body, "kind", std::nullopt);
  if (!kind) return base::forward_error(kind);
  const auto unit = name_member(body, "unit", is_of_all(*kind) ? std::optional<std::string>("") : std::nullopt);
  if (!unit) return base::forward_error(unit);
  const auto campaign = name_member(body, "campaign", "");
  if (!campaign) return base::forward_error(campaign);
  const auto format = name_member(body, "format", "");
  if (!format) return base::forward_error(format);
  const json simulated = body.value("simulated", json(false));
  if (!simulated.is_boolean()) return base::bad_input("the member is neither true nor false", "simulated");
  const json sign = body.value("sign", json(false));
  if (!sign.is_boolean()) return base::bad_input("the member is neither true nor false", "sign");
  const auto effects = effects_member(body);
  if (!effects) return base::forward_error(effects);
  const auto model = counted_member(body, "model");
  if (!model) return base::forward_error(model);
  const auto accel_id = counted_member(body, "accel_id");
  if (!accel_id) return base::forward_error(accel_id);
  const auto gyro_id = counted_member(body, "gyro_id");
  if (!gyro_id) return base::forward_error(gyro_id);
  return jobs.start({*kind, *unit, *campaign, *format, simulated, *user, *effects, sign, *model, *accel_id, *gyro_id});
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
  static const std::vector<JobQuestion> questions = {{"units", answer_units},
                                                     {"unit", answer_unit},
                                                     {"fleet", answer_fleet},
                                                     {"jobs", answer_jobs},
                                                     {"job", answer_job}};
  return questions;
}

const std::vector<JobOrder>& job_orders() {
  static const std::vector<JobOrder> orders = {{"jobs", do_start}, {kCancelJob, do_cancel}};
  return orders;
}

std::optional<json> job_to_cancel(const JobRunner& jobs, const json& body) {
  const auto id = body.find("id");
  if (id == body.end() || !id->is_number_integer()) return std::nullopt;
  auto job = jobs.show(id->get<std::int64_t>());
  if (!job) return std::nullopt;
  return *std::move(job);
}

Result<JobRunner::MadeFile> job_file(const JobRunner& jobs, const Parameters& parameters) {
  const auto id = job_id(parameters);
  if (!id) return base::forward_error(id);
  return jobs.file(*id);
}

}  // namespace soak::station
