// SPDX-License-Identifier: Apache-2.0
#include "station/http/server.h"

#include <httplib.h>

#include <chrono>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "base/text.h"
#include "station/http/access_api.h"
#include "station/http/address.h"
#include "station/http/alarms_api.h"
#include "station/http/answers.h"
#include "station/http/api.h"
#include "station/http/audit_api.h"
#include "station/http/connections.h"
#include "station/http/event_feed.h"
#include "station/http/front.h"
#include "station/http/jobs_api.h"
#include "station/http/metrics.h"
#include "station/http/records_api.h"
#include "station/http/runs_api.h"
#include "station/http/stream_places.h"
#include "station/http/unit_file_api.h"
#include "station/http/units_api.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using base::ErrorKind;

constexpr std::chrono::seconds kStreamsEndWithin{1};
constexpr std::chrono::milliseconds kPoll{1};
constexpr int kAnswered = 200;  // status of HTTP
const std::string kStationWrite = std::string(kApiPath) + "station/write";
const std::string kEventsPath = std::string(kApiPath) + "events";

}  // namespace

struct HttpServer::Running {
  Running(StationService& service, HostPort listen_address, std::filesystem::path folder,
          std::vector<std::string> names, TlsContext tls_or_none, AlarmSender* alarm_sender, SettingsDesk* desk)
      : tls(std::move(tls_or_none)),
        lab(service),
        address(std::move(listen_address)),
        data_folder(std::move(folder)),
        runs(data_folder),
        jobs(data_folder),
        own_names(std::move(names)),
        access(service, tls ? std::optional(data_folder) : std::nullopt),
        feed(service),
        alarms(alarm_sender),
        settings(desk) {
    own_names.push_back(host_of(to_text(address)));
    for (const std::string& name : names_of_machine()) own_names.push_back(name);
    prepare(listener);
    listener.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      const auto refusal = refusal_before_body(request);
      if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
      refuse(response, *refusal);
      if (refusal->status == 403 && wants_page(request)) {
        send_refusal_page(response, refusal->error.message, (tls ? "https://" : "http://") + to_text(address));
      }
      if (refusal->status == 401 && wants_page(request)) response.set_redirect("/login.html", 303);
      return httplib::Server::HandlerResponse::Handled;
    });
    add_routes();
  }

  ~Running() {
    feed.stop();
    // The listener cuts off what is still being sent when it stops.
    const auto latest_end = std::chrono::steady_clock::now() + kStreamsEndWithin;
    while (streams.taken() > 0 && std::chrono::steady_clock::now() < latest_end) std::this_thread::sleep_for(kPoll);
    thread.stop();
  }

  /// Why a request is refused by its head alone, before anything of its body is read or unpacked.
  std::optional<Refusal> refusal_before_body(const httplib::Request& request) {
    if (auto stranger = refused_by_origin(request, tls != nullptr, own_names)) return stranger;
    if (auto unknown = access.refusal(request)) return unknown;
    return refused_by_body(request);
  }

  void add_routes() {
    access.add_routes(listener);
    listener.Get(kApiPath + std::string("alive"), [this](const auto&, auto& response) { answer(response, alive()); });
    for (const ApiQuestion& question : api_questions()) add_question(question);
    for (const auto* questions : {&run_questions(), &audit_questions(), &unit_questions()}) {
      for (const RunQuestion& question : *questions) {
        listener.Get(kApiPath + std::string(question.name), [this, &question](const auto& request, auto& response) {
          answer(response, question.answer(runs, request.params));
        });
      }
    }
    for (const ApiCommand& command : api_commands()) {
      add_post("campaign/" + std::string(command.name),
               [this, &command](const nlohmann::json& body) { return command.carry_out(lab, body); });
    }
    for (const JobQuestion& question : job_questions()) {
      listener.Get(kApiPath + std::string(question.name), [this, &question](const auto& request, auto& response) {
        answer(response, question.answer(runs, jobs, request.params));
      });
    }
    for (const JobOrder& order : job_orders()) {
      add_post(std::string(order.name),
               [this, &order](const nlohmann::json& body) { return order.carry_out(jobs, body); });
    }
    listener.Get(kApiPath + std::string("job/file"), [this](const auto& request, auto& response) {
      send_attached(response, job_file(jobs, request.params));
    });
    listener.Get(kApiPath + std::string("unit/file"), [this](const auto& request, auto& response) {
      send_attached(response, unit_file(runs, request.params, access.account_of(request)));
    });
    listener.Get(kApiPath + std::string("references"), [this](const auto& request, auto& response) {
      answer(response, references_answer(runs, request.params));
    });
    listener.Get(kApiPath + std::string("references/released"), [this](const auto& request, auto& response) {
      answer(response, released_with_answer(runs, request.params));
    });
    listener.Get(kApiPath + std::string("key"),
                 [this](const auto& request, auto& response) { answer(response, key_answer(runs, request.params)); });
    for (const RecordCommand& command : record_commands()) {
      add_post(std::string(command.name),
               [this, &command](const nlohmann::json& body) { return command.carry_out(lab, runs, body); });
    }
    listener.Get(kApiPath + std::string("alarms"), [this](const auto& request, auto& response) {
      answer(response, alarms_answer(alarms, request.params));
    });
    add_post("alarms/test", [this](const nlohmann::json& body) { return test_alarms(alarms, body); });
    add_settings();
    add_post("run/void", [this](const nlohmann::json& body) { return void_run(runs, body); });
    listener.Get(kEventsPath, [this](const auto& request, auto& response) { send_events(request, response); });
    listener.Get("/metrics", [this](const auto&, auto& response) { send_metrics(response); });
    listener.Get("/([^/]*)", send_page);
  }

  /// The station's own settings; one that cannot be set anew refuses (409).
  void add_settings() {
    const auto with_desk = [this](const auto& ask) -> base::Result<nlohmann::json> {
      if (settings != nullptr) return ask();
      return base::bad_input("the settings of this station cannot be changed here", "state");
    };
    listener.Get(kApiPath + std::string("station"), [this, with_desk](const auto& request, auto& response) {
      const auto known = only_parameters(request.params, {});
      if (!known) return answer(response, base::forward_error(known));
      answer(response, with_desk([this] { return settings->document(); }));
    });
    add_post("station/check", [this, with_desk](const nlohmann::json& body) {
      return with_desk([&] { return settings->check(body); });
    });
    add_post("station/tell",
             [this, with_desk](const nlohmann::json& body) { return with_desk([&] { return settings->tell(body); }); });
    add_post("station/write", [this, with_desk](const nlohmann::json& body) {
      return with_desk([&] { return settings->write(body, jobs); });
    });
    // Called when an answer is sent: who has had the settings written shall hear of it before this server ends.
    listener.set_logger([this](const httplib::Request& request, const httplib::Response& response) {
      if (request.path == kStationWrite && response.status == kAnswered) settings->answered();
    });
  }

  void add_question(const ApiQuestion& question) {
    listener.Get(kApiPath + std::string(question.name), [this, &question](const auto& request, auto& response) {
      const auto parameter = only_parameter(request.params, std::string(question.parameter));
      if (!parameter) return answer(response, base::forward_error(parameter));
      answer(response, question.answer(lab, *parameter, feed.latest().newest_log));
    });
  }

  void add_post(const std::string& name,
                std::function<base::Result<nlohmann::json>(const nlohmann::json& body)> carry_out) {
    listener.Post(kApiPath + name, [this, name, carry_out = std::move(carry_out)](const auto& request, auto& response) {
      if (!is_json(request)) {
        return refuse(response, {415, {ErrorKind::bad_input, "the body must be application/json", "Content-Type"}});
      }
      auto body = parse_body(request.body);
      if (!body) return answer(response, body);
      if (const auto refusal = access.sign(request, role_needed(name, *body), *body)) return refuse(response, *refusal);
      answer(response, carry_out(*body));
    });
  }

  /// Who may begin a job may end it.
  [[nodiscard]] Role role_needed(const std::string& name, const nlohmann::json& body) const {
    if (name != kCancelJob) return role_of_command(name, body);
    const auto job = job_to_cancel(jobs, body);
    return job ? role_of_command("jobs", *job) : Role::operating;
  }

  /// For programs of this machine that must know whether the chamber is in hand: `turn` rises while the engine works.
  [[nodiscard]] nlohmann::json alive() const {
    const std::uint64_t turn = lab.status_version();
    return {{"turn", turn}, {"chamber_connected", lab.status().at("chamber").at("connected")}};
  }

  /// For Prometheus.
  void send_metrics(httplib::Response& response) const {
    std::error_code failure;
    const auto space = std::filesystem::space(data_folder, failure);
    const double free_bytes = failure ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(space.available);
    const HostFigures host{free_bytes, static_cast<double>(heap_in_use_bytes())};
    response.set_content(metrics_text(lab.status(), host), "text/plain; version=0.0.4; charset=utf-8");
  }

  /// To be saved, not shown: whatever is in it, it is not a page of the station.
  template <class File>
  static void send_attached(httplib::Response& response, const base::Result<File>& file) {
    if (!file) return refuse(response, {http_status(file.error()), file.error()});
    response.set_header("Content-Disposition", "attachment; filename=\"" + file->name + '"');
    response.set_content(file->content, "application/octet-stream");
  }

  static void send_page(const httplib::Request& request, httplib::Response& response) {
    send_file(response, request.matches[1].length() == 0 ? "index.html" : request.matches[1].str());
  }

  void send_events(const httplib::Request& request, httplib::Response& response) {
    // Held for as long as the library keeps the provider.
    const auto place = streams.take(access.account_of(request), request.remote_addr);
    if (!place) return refuse(response, {place.error().where == kTooManyStreams ? 429 : 503, place.error()});
    listener.make_endless();
    const auto last_id = base::parse_int(request.get_header_value("Last-Event-ID"));
    const auto stream = std::make_shared<EventStream>(lab, feed, last_id);
    const auto may_read = access.watch(request);
    response.set_chunked_content_provider("text/event-stream",
                                          [stream, place = *place, may_read](std::size_t, httplib::DataSink& sink) {
                                            const auto text = stream->next();
                                            // After the wait: what came meanwhile is not for who has lost access.
                                            if (!text || !may_read()) {
                                              sink.done();
                                              return true;
                                            }
                                            if (text->empty()) return sink.is_writable();
                                            return sink.write(text->data(), text->size());
                                          });
  }

  TlsContext tls;  ///< null = in the clear, and without accounts
  StationService& lab;
  HostPort address;
  std::filesystem::path data_folder;
  RunArchive runs;
  JobRunner jobs;
  std::vector<std::string> own_names;
  AccessApi access;
  EventFeed feed;
  AlarmSender* alarms;
  SettingsDesk* settings;  ///< null = nobody can change them here
  StreamPlaces streams{StreamPlaces::Limits{}};
  BoundedListener listener{ConnectionLimits{}, tls.get()};
  ListenerThread thread{listener};
};

HttpServer::HttpServer(StationService& lab, std::string listen, std::filesystem::path data_folder,
                       std::vector<std::string> allowed_hosts, std::optional<CertificateFiles> certificate,
                       AlarmSender* alarms, SettingsDesk* settings)
    : lab_(lab),
      listen_(std::move(listen)),
      data_folder_(std::move(data_folder)),
      allowed_hosts_(std::move(allowed_hosts)),
      certificate_(std::move(certificate)),
      alarms_(alarms),
      settings_(settings) {}

HttpServer::~HttpServer() = default;

base::Result<int> HttpServer::start() {
  auto address = parse_host_port(listen_);
  if (!address) return base::forward_error(address);
  base::Result<TlsContext> tls = certificate_ ? tls_context(*certificate_) : TlsContext();
  if (!tls) return base::forward_error(tls);
  auto running = std::make_unique<Running>(lab_, *std::move(address), data_folder_, allowed_hosts_, *std::move(tls),
                                           alarms_, settings_);
  const auto port = running->thread.start(running->address);
  if (port) running_ = std::move(running);
  return port;
}

void HttpServer::stop() { running_.reset(); }

std::vector<std::string> HttpServer::routes() const {
  std::vector<std::string> lines;
  if (!running_) return lines;
  for (const Route& route : running_->listener.routes()) lines.push_back(route.method + ' ' + route.path);
  return lines;
}

}  // namespace soak::station
