// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "station/access/gate.h"
#include "station/http/answers.h"
#include "station/http/connections.h"
#include "station/lab/station_service.h"

namespace soak::station {

/// The least role that may do POST /api/v1/`name` with that body; engineer where nothing else is known of it.
[[nodiscard]] Role role_of_command(std::string_view name, const nlohmann::json& body);

/// Who asks over HTTP: log-in, log-out, cookies and tokens (docs/access.md). Of a station without a gate, which only
/// its own machine reaches, everybody may do everything, under any name. Any thread may call.
class AccessApi {
 public:
  /// `data_folder`: whose accounts count; nothing = no gate. `lab`, whose event log tells of log-ins, must outlive it.
  AccessApi(StationService& lab, const std::optional<std::filesystem::path>& data_folder);

  /// Why a request is refused by its head alone: 401 for who is not known, 403 for a command that some other page may
  /// have made the browser send. What tells nothing passes: the files of the pages, the log-in, GET /api/v1/alive.
  [[nodiscard]] std::optional<Refusal> refusal(const httplib::Request& request);

  /// Why a command that needs that role is refused to its caller (403); else its member `user` is the caller's name
  /// from here on, whatever it said before.
  [[nodiscard]] std::optional<Refusal> sign(const httplib::Request& request, Role needed, nlohmann::json& body);

  /// The name of the account that asks; empty of a station without a gate, and of who is not known.
  [[nodiscard]] std::string account_of(const httplib::Request& request);

  /// Whether the caller of a request may still read, as a function that can be asked again and again. Each time counts
  /// as a use of the session.
  [[nodiscard]] std::function<bool()> watch(const httplib::Request& request);

  /// POST /api/v1/login and logout, GET /api/v1/session.
  void add_routes(BoundedListener& listener);

 private:
  void log_in(const httplib::Request& request, httplib::Response& response);
  void log_out(const httplib::Request& request, httplib::Response& response);
  [[nodiscard]] nlohmann::json session(const httplib::Request& request);

  std::optional<Gate> gate_;
};

}  // namespace soak::station
