// SPDX-License-Identifier: Apache-2.0
#include "station/http/setup_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "hal/devices/survey.h"
#include "station/config/station_config.h"
#include "station/http/api.h"
#include "station/http/front.h"
#include "station/http/members.h"
#include "station/http/parameters.h"
#include "station/http/setup_body.h"
#include "station/http/setup_documents.h"
#include "station/io/host.h"
#include "station/lab/slot_look.h"
#include "station/lab/survey_json.h"
#include "station/setup/setup_check.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

const std::string kWritePath = std::string(kApiPath) + "setup/write";
const std::string kUsePath = std::string(kApiPath) + "setup/use";
constexpr int kDone = 200;  // status of HTTP

/// What `soak chamber probe` does: reads, and writes nothing.
Result<json> try_controller(const json& body) {
  if (auto known = only_members(body, {"section", "chamber", "fixture", "power"}); !known)
    return base::forward_error(known);
  const auto section = line_member(body, "section", std::nullopt);
  if (!section) return base::forward_error(section);
  constexpr std::array<std::string_view, 3> kSections = {"chamber", "fixture", "power"};
  if (std::ranges::find(kSections, *section) == kSections.end()) {
    return base::bad_input("neither 'chamber' nor 'fixture' nor 'power'", "section");
  }
  const auto entered = controller_of(body, *section);
  if (!entered) return base::forward_error(entered);
  const auto map = entered_controller(*section, *entered);
  if (!map) return base::forward_error(map);
  const auto survey = hal::survey_chamber(*map);
  if (!survey) return base::fail(survey.error().kind, survey.error().message, *section);
  return survey_document(*map, *survey);
}

Result<json> look_into_entered(const json& body, const std::atomic<bool>& stop) {
  const auto form = setup_form_of(body);
  if (!form) return base::forward_error(form);
  const auto slots = entered_slots(*form);
  if (!slots) return base::forward_error(slots);
  if (auto own = refuse_shared_ports(*form); !own) return base::forward_error(own);
  const auto findings = look_into_slots(*slots, stop);
  if (!findings) return base::forward_error(findings);
  return look_document(*findings);
}

/// Sends a test over each way that was entered.
Result<json> test_entered_alarms(const json& body, const std::atomic<bool>& stop) {
  if (auto known = only_members(body, {"mail", "webhook", "user"}); !known) return base::forward_error(known);
  const auto user = line_member(body, "user", "unknown");
  if (!user) return base::forward_error(user);
  const auto form = setup_form_of(body);
  if (!form) return base::forward_error(form);
  return send_entered(*form, std::nullopt, *user, stop);
}

}  // namespace

struct SetupServer::Running {
  Running(HostPort listen, std::filesystem::path config_file, db::Catalog& log)
      : address(std::move(listen)), file(std::move(config_file)), catalog(log) {
    own_names = names_of_machine();
    own_names.push_back(host_of(to_text(address)));
    prepare(listener);
    listener.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      auto refusal = refused_by_origin(request, false, own_names);
      const bool is_stranger = refusal.has_value();
      if (!refusal) refusal = refused_by_body(request);
      if (!refusal) return httplib::Server::HandlerResponse::Unhandled;
      refuse(response, *refusal);
      if (is_stranger && wants_page(request)) {
        send_refusal_page(response, refusal->error.message, "http://" + to_text(address));
      }
      return httplib::Server::HandlerResponse::Handled;
    });
    // Called when an answer is sent: who has asked for the file shall hear that it is there.
    listener.set_logger([this](const httplib::Request& request, const httplib::Response& response) {
      const bool is_end = request.path == kWritePath || request.path == kUsePath;
      if (is_end && response.status == kDone) tell_written();
    });
    add_routes();
  }

  ~Running() {
    stop = true;
    thread.stop();
  }

  void add_routes() {
    listener.Get(kApiPath + std::string("setup"), [this](const auto& request, auto& response) {
      if (const auto known = only_parameters(request.params, {}); !known) {
        return answer(response, base::forward_error(known));
      }
      answer(response, setup_choices(file));
    });
    add_post("setup/try", [this](const json& body) { return in_turn([&] { return try_controller(body); }); });
    add_post("setup/look", [this](const json& body) { return in_turn([&] { return look_into_entered(body, stop); }); });
    add_post("setup/tell",
             [this](const json& body) { return in_turn([&] { return test_entered_alarms(body, stop); }); });
    add_post("setup/check", [this](const json& body) -> Result<json> {
      const auto form = setup_form_of(body);
      if (!form) return base::forward_error(form);
      const SetupCheck check = check_setup(*form, file);
      return setup_check_document(check.toml, check.mistakes);
    });
    add_post("setup/write", [this](const json& body) {
      const std::lock_guard lock(file_turn);
      return write(body);
    });
    add_post("setup/use", [this](const json& body) {
      const std::lock_guard lock(file_turn);
      return use(body);
    });
    listener.Get("/([^/]*)", [](const auto& request, auto& response) {
      const std::string name = request.matches[1].str();
      send_file(response, name.empty() || name == "index.html" ? "setup.html" : name);
    });
  }

  void add_post(const std::string& name, std::function<Result<json>(const json& body)> carry_out) {
    listener.Post(kApiPath + name, [this, carry_out = std::move(carry_out)](const auto& request, auto& response) {
      if (!is_json(request)) {
        return refuse(response,
                      {415, {base::ErrorKind::bad_input, "the body must be application/json", "Content-Type"}});
      }
      const auto body = parse_body(request.body);
      if (!body) return answer(response, body);
      answer(response, carry_out(*body));
    });
  }

  Result<json> write(const json& body) {
    const auto user = line_member(body, "user", "unknown");
    if (!user) return base::forward_error(user);
    const auto form = setup_form_of(body);
    if (!form) return base::forward_error(form);
    const SetupCheck check = check_setup(*form, file);
    if (!check.mistakes.empty()) return base::bad_input(check.mistakes[0].message, check.mistakes[0].field);
    if (auto written = write_new_config(file, check.toml, secrets_of(*form)); !written) {
      return base::forward_error(written);
    }
    note_set_up(fmt::format("configuration written on the set-up page, {} slots", form->slots.size()), *user);
    log_line("wrote " + file.string());
    return json{{"file", file.string()}};
  }

  /// Goes on with the file that is there although nobody has written it here.
  [[nodiscard]] Result<json> use(const json& body) {
    if (auto known = only_members(body, {"user"}); !known) return base::forward_error(known);
    const auto user = line_member(body, "user", "unknown");
    if (!user) return base::forward_error(user);
    std::error_code failure;
    if (!std::filesystem::exists(file, failure) && !failure) {
      return base::bad_input(fmt::format("there is no file {}", file.string()), "state");
    }
    if (const auto config = read_station_config(file); !config) return base::forward_error(config);
    note_set_up("went on with the configuration that was there", *user);
    return json{{"file", file.string()}};
  }

  void note_set_up(const std::string& what, const std::string& user) {
    const auto noted = catalog.log_event({now_utc_s(), "station_set_up", file.string(), what, user});
    if (!noted) log_line("the event log does not tell of the configuration: " + noted.error().message);
  }

  /// Devices have one reader at a time. Who asks meanwhile does not wait: the end would have to wait for all of them.
  template <class Ask>
  Result<json> in_turn(Ask ask) {
    const std::unique_lock lock(turn, std::try_to_lock);
    if (!lock.owns_lock() || stop) {
      return base::bad_input("a device is being asked already: try again when that is over", "state");
    }
    return ask();
  }

  void tell_written() {
    const std::lock_guard lock(mutex);
    is_told = true;
    told.notify_all();
  }

  HostPort address;
  std::filesystem::path file;
  db::Catalog& catalog;
  std::vector<std::string> own_names;
  std::mutex turn;                 ///< of devices
  std::mutex file_turn;            ///< of the configuration
  std::atomic<bool> stop = false;  ///< of a look into the slots
  std::mutex mutex;
  std::condition_variable told;
  bool is_told = false;  ///< whoever has had the file written has the answer
  BoundedListener listener{ConnectionLimits{}};
  ListenerThread thread{listener};
};

SetupServer::SetupServer(HostPort listen, std::filesystem::path file, db::Catalog& catalog)
    : running_(std::make_unique<Running>(std::move(listen), std::move(file), catalog)) {}

SetupServer::~SetupServer() = default;

Result<int> SetupServer::start() { return running_->thread.start(running_->address); }

bool SetupServer::wait_for(std::chrono::milliseconds longest) {
  std::unique_lock lock(running_->mutex);
  return running_->told.wait_for(lock, longest, [this] { return running_->is_told; });
}

}  // namespace soak::station
