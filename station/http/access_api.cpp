// SPDX-License-Identifier: Apache-2.0
#include "station/http/access_api.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "station/access/secrets.h"
#include "station/http/address.h"
#include "station/http/api.h"
#include "station/http/members.h"
#include "station/http/web_files.h"
#include "station/jobs/job.h"

namespace soak::station {
namespace {

using base::ErrorKind;
using nlohmann::json;

/// A browser takes a cookie of such a name only over TLS, from the host itself and for all of its paths (RFC 6265bis,
/// 4.1.3.2): no neighbour in the same domain can plant one. It keeps cookies apart by host, but not by port (RFC 6265,
/// 8.5): with the port in their names, which is that of the Host header, two stations on one machine do not share one.
std::string cookie_name(const httplib::Request& request) {
  constexpr int kHttpsPort = 443;  // a Host header leaves it out
  const auto host = parse_host_port(request.get_header_value("Host"));
  return "__Host-soak-" + std::to_string(host ? host->port : kHttpsPort);
}

constexpr std::string_view kCookieRules = "; Path=/; Secure; HttpOnly; SameSite=Strict";
constexpr std::string_view kBearer = "Bearer ";
/// No form and no link can make a browser send this header; a script of another origin would have to ask first, which
/// this station never grants.
constexpr const char* kOwnPage = "X-Requested-With";

/// The value of the first of our cookies; a browser sends one.
std::string cookie_of(const httplib::Request& request) {
  std::string_view rest;
  const std::string name = cookie_name(request);
  const std::string all = request.get_header_value("Cookie");
  for (rest = all; !rest.empty();) {
    const std::string_view pair = rest.substr(0, rest.find(';'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const std::string_view trimmed = pair.substr(std::min(pair.size(), pair.find_first_not_of(' ')));
    const std::size_t equals = trimmed.find('=');
    if (trimmed.substr(0, equals) == name && equals != std::string_view::npos) {
      return std::string(trimmed.substr(equals + 1));
    }
  }
  return {};
}

Shown shown_by(const httplib::Request& request) {
  const std::string authorization = request.get_header_value("Authorization");
  if (authorization.starts_with(kBearer)) return {{}, authorization.substr(kBearer.size())};
  return {cookie_of(request), {}};
}

/// What tells nothing of this station: files that are the same at every one, the log-in, the sign of life.
bool is_open_to_all(const httplib::Request& request) {
  constexpr std::array<std::string_view, 2> kOpen = {"login", "alive"};
  const std::string_view path = request.path;
  if (path.starts_with(kApiPath)) {
    return std::ranges::find(kOpen, path.substr(std::string_view(kApiPath).size())) != kOpen.end();
  }
  return path.starts_with('/') && path != "/index.html" && find_web_file(path.substr(1)) != nullptr;
}

/// Whether a page of this station has sent a command: its Origin has been compared already where it is there.
bool is_from_own_page(const httplib::Request& request) {
  return request.has_header("Origin") && request.get_header_value(kOwnPage) == "soak";
}

Refusal not_known() {
  return {401,
          {ErrorKind::bad_input, "log in, or show a token ('soak user token' makes one, --token-file shows it)",
           "account"}};
}

}  // namespace

Role role_of_command(std::string_view name, const json& body) {
  constexpr std::array<std::string_view, 2> kOperating = {"unit/add", "procedures/new"};
  if (name.starts_with("campaign/") || std::ranges::find(kOperating, name) != kOperating.end()) return Role::operating;
  if (name != "jobs") return Role::engineer;
  constexpr std::array<std::string_view, 8> kOperators = {"fit",    kFitAll,         "verify",   kVerifyAll,
                                                          "report", kReportCampaign, "gap_find", "gap_show"};
  const json kind = body.value("kind", json());
  const bool is_operators =
      kind.is_string() && std::ranges::find(kOperators, kind.get<std::string>()) != kOperators.end();
  return is_operators ? Role::operating : Role::engineer;
}

AccessApi::AccessApi(StationService& lab, const std::optional<std::filesystem::path>& data_folder) {
  if (!data_folder) return;
  gate_.emplace(*data_folder, [&lab](const std::string& kind, const std::string& account, const std::string& text) {
    const bool came_in = kind == "logged_in" || kind == "logged_out";
    lab.note(kind, account.empty() ? "unknown account" : account, text, came_in ? account : "");
  });
}

std::optional<Refusal> AccessApi::refusal(const httplib::Request& request) {
  if (!gate_) return std::nullopt;
  const Shown shown = shown_by(request);
  if (request.method == "POST" && shown.token.empty() && !is_from_own_page(request)) {
    return Refusal{403, {ErrorKind::bad_input, "the command does not come from a page of this station", "headers"}};
  }
  if (is_open_to_all(request) || gate_->caller(shown)) return std::nullopt;
  return not_known();
}

std::optional<Refusal> AccessApi::sign(const httplib::Request& request, Role needed, json& body) {
  if (!gate_) return std::nullopt;
  const auto caller = gate_->caller(shown_by(request));
  if (!caller) return not_known();
  if (caller->role < needed) {
    return Refusal{403,
                   {ErrorKind::bad_input,
                    std::string(name_of(caller->role)) + " " + caller->name + " may not do this: it needs the role " +
                        std::string(name_of(needed)),
                    "role"}};
  }
  body["user"] = caller->name;
  return std::nullopt;
}

std::string AccessApi::account_of(const httplib::Request& request) {
  const auto caller = gate_ ? gate_->caller(shown_by(request)) : std::nullopt;
  return caller ? caller->name : "";
}

std::function<bool()> AccessApi::watch(const httplib::Request& request) {
  if (!gate_) return [] { return true; };
  return [this, shown = shown_by(request)] { return gate_->caller(shown).has_value(); };
}

void AccessApi::add_routes(BoundedListener& listener) {
  listener.Get(kApiPath + std::string("session"),
               [this](const auto& request, auto& response) { answer(response, session(request)); });
  if (!gate_) return;
  listener.Post(kApiPath + std::string("login"),
                [this](const auto& request, auto& response) { log_in(request, response); });
  listener.Post(kApiPath + std::string("logout"),
                [this](const auto& request, auto& response) { log_out(request, response); });
}

void AccessApi::log_in(const httplib::Request& request, httplib::Response& response) {
  if (!is_json(request)) {
    return refuse(response, {415, {ErrorKind::bad_input, "the body must be application/json", "Content-Type"}});
  }
  const auto body = parse_body(request.body);
  if (!body) return answer(response, body);
  if (auto known = only_members(*body, {"name", "password"}); !known)
    return answer(response, base::forward_error(known));
  const auto name = line_member(*body, "name", std::nullopt);
  if (!name) return answer(response, base::forward_error(name));
  const auto password = text_member(*body, "password", std::nullopt);
  if (!password) return answer(response, base::forward_error(password));
  if (password->size() > kLongestPassword) {
    return answer(response, base::bad_input("longer than any password", "password"));
  }
  const auto entry = gate_->log_in(*name, *password, request.remote_addr);
  if (!entry && entry.error().where == kTooManyTries) return refuse(response, {429, entry.error()});
  if (!entry && entry.error().where == kWrongPassword) return refuse(response, {401, entry.error()});
  if (!entry) return answer(response, base::forward_error(entry));
  gate_->replace(cookie_of(request));  // that of before, which the browser forgets now
  response.set_header("Set-Cookie", cookie_name(request) + "=" + entry->session + std::string(kCookieRules));
  answer(response, json{{"name", entry->caller.name}, {"role", name_of(entry->caller.role)}});
}

void AccessApi::log_out(const httplib::Request& request, httplib::Response& response) {
  gate_->log_out(shown_by(request).session, request.remote_addr);
  response.set_header("Set-Cookie", cookie_name(request) + "=; Max-Age=0" + std::string(kCookieRules));
  answer(response, json::object());
}

json AccessApi::session(const httplib::Request& request) {
  const auto caller = gate_ ? gate_->caller(shown_by(request)) : std::nullopt;
  return {{"accounts", gate_.has_value()},
          {"name", caller ? json(caller->name) : json()},
          {"role", caller ? json(name_of(caller->role)) : json()}};
}

}  // namespace soak::station
