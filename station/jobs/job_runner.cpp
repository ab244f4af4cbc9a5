// SPDX-License-Identifier: Apache-2.0
#include "station/jobs/job_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

using nlohmann::json;

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

bool is_of_campaign(const std::string& kind) {
  return kind == "verify" || kind == kVerifyAll || kind == kReportCampaign;
}

json new_document(const JobRequest& request, std::int64_t id) {
  json effects;
  if (request.kind == "gap_accept") effects = request.effects;
  return {{"id", id},
          {"kind", request.kind},
          {"unit", request.unit},
          {"model", nullptr},
          {"campaign", text_or_null(is_of_campaign(request.kind) ? request.campaign : "")},
          {"format", text_or_null(request.kind == "export" || request.kind == kExportAll ? request.format : "")},
          {"effects", std::move(effects)},
          {"sign", request.kind == "export" ? json(request.sign) : json()},
          {"user", request.user},
          {"state", "running"},
          {"progress", nullptr},
          {"doing", nullptr},
          {"started_utc_s", now_utc_s()},
          {"ended_utc_s", nullptr},
          {"exit_status", nullptr},
          {"message", nullptr},
          {"result", nullptr},
          {"file", nullptr}};
}

/// "verify against check-2027", "export as blob", "gap_accept of sensor_lag"
std::string what_it_does(const json& job) {
  std::string text = job["kind"];
  const json effects = job.value("effects", json::array());
  for (std::size_t i = 0; i < effects.size(); ++i) text += (i == 0 ? " of " : ", ") + effects[i].get<std::string>();
  if (const json campaign = job.value("campaign", json()); campaign.is_string()) {
    text += (job["kind"] == kReportCampaign ? " of " : " against ") + campaign.get<std::string>();
  }
  if (const json format = job.value("format", json()); format.is_string()) text += " as " + format.get<std::string>();
  if (job.value("sign", json()) == true) text += ", signed";
  return text;
}

std::string how_it_ended(const json& job) {
  std::string text = job["state"];
  if (job.value("result", json()).is_object()) {
    if (job.value("/result/model"_json_pointer, json()).is_number())
      text += fmt::format(", model {}", job["result"]["model"].dump());
    if (const json verdict = job.value("/result/verdict"_json_pointer, json()); verdict.is_string())
      text += ", verdict " + verdict.get<std::string>();
  }
  if (job["state"] == "failed" && job["message"].is_string()) text += ": " + job["message"].get<std::string>();
  return text;
}

/// Whether the end of a job is in the event log. One job at a time runs: an end of the same words after its start is
/// its own.
base::Result<bool> has_logged_end(const db::Catalog& catalog, const json& job) {
  constexpr std::size_t kMost = 100;
  const auto ends = catalog.find_events({.kind = "job_ended",
                                         .subject = job["unit"].get<std::string>(),
                                         .user = {},
                                         .from_utc_s = job["started_utc_s"].get<double>(),
                                         .to_utc_s = {},
                                         .before = {},
                                         .most = kMost});
  if (!ends) return base::forward_error(ends);
  const std::string words = what_it_does(job) + ": ";
  return std::ranges::any_of(*ends, [&](const db::EventRow& end) { return end.text.starts_with(words); });
}

base::Error not_kept(std::int64_t id) {
  return {base::ErrorKind::bad_input, fmt::format("there is no job {}, or it is not kept any more", id), "id"};
}

}  // namespace

std::filesystem::path soak_beside_this_program() {
  std::error_code failure;
  return std::filesystem::read_symlink("/proc/self/exe", failure).parent_path() / "soak";
}

JobRunner::JobRunner(std::filesystem::path data_folder, std::filesystem::path program)
    : data_folder_(data_folder.empty() ? std::move(data_folder) : std::filesystem::absolute(data_folder)),
      program_(std::move(program)),
      shelf_(data_folder_ / "jobs") {
  if (!data_folder_.empty()) end_those_cut_short();
  thread_ = std::thread([this] { work(); });
}

void JobRunner::end_those_cut_short() {
  std::vector<json> ended = shelf_.load();
  for (const json& job : ended) shelf_.put(job);
  // A document is written before its end is logged: where soakd died in between, the last one ended and nobody knows.
  if (const json last = shelf_.last(); ended.empty() && !last.is_null()) ended.push_back(last);
  if (ended.empty()) return;
  const auto catalog = open_existing_catalog(data_folder_.string());
  for (const json& job : ended) {
    const auto logged = catalog ? has_logged_end(*catalog, job) : base::Result<bool>(base::forward_error(catalog));
    if (!logged || !*logged) note_end(job, job["user"]);
  }
}

void JobRunner::note_end(const json& job, const std::string& user) const {
  note("job_ended", job, what_it_does(job) + ": " + how_it_ended(job), user);
}

JobRunner::~JobRunner() {
  {
    const std::scoped_lock lock(mutex_);
    quits_ = true;
    stop_child_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

base::Result<json> JobRunner::start(const JobRequest& request) {
  if (data_folder_.empty()) return base::bad_input("the station has no data folder", "unit");
  std::int64_t id = 0;
  {
    const std::scoped_lock lock(mutex_);
    if (held_) {
      return base::bad_input("the station is about to begin anew with other settings: wait some seconds", "state");
    }
    if (busy_) {
      return base::bad_input("another job is running; wait until it has ended, or cancel it", "state");
    }
    busy_ = true;
    id = shelf_.next_id();
  }
  auto job = prepare(request, id);
  const std::scoped_lock lock(mutex_);
  if (!job) {
    busy_ = false;
    changed_.notify_all();
    return base::forward_error(job);
  }
  cancelled_by_.clear();
  stop_child_ = quits_;
  shelf_.put(job->document);
  json document = job->document;
  waiting_ = *std::move(job);
  changed_.notify_all();
  return document;
}

base::Status JobRunner::hold() {
  const std::scoped_lock lock(mutex_);
  if (busy_) return base::bad_input("a job is running: wait until it has ended, or cancel it", "state");
  held_ = true;
  return {};
}

void JobRunner::end_hold() {
  const std::scoped_lock lock(mutex_);
  held_ = false;
}

base::Result<JobRunner::UnderWay> JobRunner::prepare(const JobRequest& request, std::int64_t id) {
  auto catalog = open_existing_catalog(data_folder_.string());
  if (!catalog) return base::forward_error(catalog);
  if (auto checked = check_job(*catalog, request); !checked) return base::forward_error(checked);
  const auto model = job_model(*catalog, request);
  if (!model) return base::forward_error(model);
  const std::filesystem::path folder = shelf_.folder_of(id);
  std::error_code failure;
  std::filesystem::remove_all(folder, failure);
  if (!std::filesystem::create_directories(folder, failure)) {
    return base::fail(base::ErrorKind::internal, "cannot create the folder: " + failure.message(), folder.string());
  }
  UnderWay job{new_document(request, id), {}};
  if (*model) job.document["model"] = **model;
  auto command = job_command(*catalog, request, folder);
  base::Status noted;
  if (command) {
    noted = catalog->log_event({now_utc_s(), "job_started", request.unit, what_it_does(job.document), request.user});
  }
  if (!command || !noted) {
    shelf_.remove_folder(id);
    return tl::unexpected(command ? noted.error() : command.error());
  }
  job.command = *std::move(command);
  job.command.arguments.push_back("--data=" + data_folder_.string());
  job.command.arguments.emplace_back("--json");
  return job;
}

base::Result<json> JobRunner::cancel(std::int64_t id, const std::string& user) {
  std::unique_lock lock(mutex_);
  const auto job = shelf_.find(id);
  if (!job) return tl::unexpected(not_kept(id));
  if ((*job)["state"] != "running") return base::bad_input("the job has ended already", "state");
  cancelled_by_ = user;
  stop_child_ = true;
  changed_.wait(lock, [&] { return !busy_ || (*shelf_.find(id))["state"] != "running"; });
  return *shelf_.find(id);
}

void JobRunner::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return quits_ || waiting_; });
    if (!waiting_) return;
    UnderWay job = *std::exchange(waiting_, std::nullopt);
    lock.unlock();
    carry_out(std::move(job));
    lock.lock();
  }
}

void JobRunner::carry_out(UnderWay job) {
  const ChildProgram child{program_, job.command.arguments, job.document["user"]};
  const auto end = run_child(child, stop_child_, [&](std::string_view errors) {
    const std::scoped_lock lock(mutex_);
    if (const auto step = job_step(errors)) {
      shelf_.tell_step(job.document["id"], step->doing, step->share ? json(*step->share) : json());
    }
  });
  if (end) {
    finish(job.document, job.command, *end);
  } else {
    finish(job.document, job.command, {127, "", end.error().where + ": " + end.error().message});
  }
  std::string cancelled_by;
  {
    const std::scoped_lock lock(mutex_);
    cancelled_by = cancelled_by_;
  }
  std::string user = job.document["user"];
  if (job.document["state"] == "cancelled") {
    job.document["message"] = cancelled_by.empty() ? "soakd was stopped" : "cancelled by " + cancelled_by;
    if (!cancelled_by.empty()) user = cancelled_by;
  }
  shelf_.write(job.document);
  note_end(job.document, user);
  const std::scoped_lock lock(mutex_);
  shelf_.put(job.document);
  busy_ = false;
  changed_.notify_all();
}

void JobRunner::finish(json& document, const JobCommand& command, const ChildEnd& end) const {
  const auto is_limits = static_cast<int>(base::ErrorKind::limits);
  document["ended_utc_s"] = now_utc_s();
  document["exit_status"] = end.exit_status;
  document["result"] = job_result(document["kind"], end.output);
  const bool is_whole_result = document["result"].is_object();
  if (!is_whole_result) document["result"] = kept_verdicts(shelf_.folder_of(document["id"]));
  const bool has_ended_well = end.exit_status == 0 || end.exit_status == is_limits;
  const bool is_done = has_ended_well && end.is_whole && is_whole_result;
  document["state"] = is_done ? "done" : end.stopped ? "cancelled" : "failed";
  if (!end.is_whole)
    document["message"] = "it printed more than can be kept";
  else if (end.exit_status != 0)
    document["message"] = job_message(end);
  else if (!is_done)
    document["message"] = "it printed no result";
  if (!is_done || command.file.empty()) return;
  std::error_code failure;
  const auto bytes = std::filesystem::file_size(shelf_.folder_of(document["id"]) / command.file, failure);
  if (!failure) document["file"] = {{"name", command.file}, {"bytes", bytes}};
}

void JobRunner::note(const std::string& kind, const json& job, const std::string& text, const std::string& user) const {
  auto catalog = open_existing_catalog(data_folder_.string());
  const base::Status noted = catalog ? catalog->log_event({now_utc_s(), kind, job["unit"], text, user})
                                     : base::Status(base::forward_error(catalog));
  if (!noted) log_line(fmt::format("not in the event log: {} of unit {}", text, job["unit"].get<std::string>()));
}

json JobRunner::list() const {
  const std::scoped_lock lock(mutex_);
  return shelf_.list();
}

base::Result<json> JobRunner::show(std::int64_t id) const {
  const std::scoped_lock lock(mutex_);
  auto job = shelf_.find(id);
  if (!job) return tl::unexpected(not_kept(id));
  return *std::move(job);
}

json JobRunner::newest(const std::string& unit, const std::string& kind) const {
  const std::scoped_lock lock(mutex_);
  return shelf_.newest(unit, kind);
}

std::map<std::string, json> JobRunner::newest_verdicts() const {
  const std::scoped_lock lock(mutex_);
  return shelf_.newest_verdicts();
}

base::Result<JobRunner::MadeFile> JobRunner::file(std::int64_t id) const {
  const std::scoped_lock lock(mutex_);
  const auto job = shelf_.find(id);
  if (!job) return tl::unexpected(not_kept(id));
  if (!(*job)["file"].is_object()) return base::bad_input("the job has made no file", "id");
  const std::string name = plain_file_name((*job)["file"].value("name", ""));
  const auto path = shelf_.folder_of(id) / name;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return base::fail(base::ErrorKind::internal, "the file is gone", path.string());
  return MadeFile{name, std::string(std::istreambuf_iterator<char>(stream), {})};
}

}  // namespace soak::station
