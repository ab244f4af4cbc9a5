// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/alarms/alarm_sender.h"
#include "station/http/settings_desk.h"
#include "station/http/tls.h"
#include "station/lab/station_service.h"

namespace soak::station {

/// The station's HTTP interface and pages: docs/http-api.md. In the clear it has no users and no passwords: who reaches
/// the address commands the station. With a certificate it speaks TLS and asks who it is: docs/access.md.
class HttpServer {
 public:
  /// `listen`: HOST:PORT, port 0 = any free one. `data_folder`: whose runs are shown and whose free space /metrics
  /// tells; empty = none. `allowed_hosts`: names of the station in addresses, besides this machine's own.
  /// `certificate`: to speak TLS with; the accounts are then those of the data folder. `alarms`: who tells people of
  /// alarms; null = nobody. `settings`: who changes those of the station; null = nobody can. All of them and the
  /// laboratory must outlive the server.
  HttpServer(StationService& lab, std::string listen, std::filesystem::path data_folder = {},
             std::vector<std::string> allowed_hosts = {}, std::optional<CertificateFiles> certificate = {},
             AlarmSender* alarms = nullptr, SettingsDesk* settings = nullptr);
  ~HttpServer();

  /// Listens and answers from threads of its own; the port. Refuses an address that is not one or not free, and a
  /// certificate that cannot be used (bad_input).
  [[nodiscard]] base::Result<int> start();
  /// Ends open event streams, finishes what is being answered (some seconds at most) and lets go of the address.
  void stop();
  /// "GET /api/v1/status": everything that it answers to while it listens; paths are patterns.
  [[nodiscard]] std::vector<std::string> routes() const;

 private:
  struct Running;
  StationService& lab_;
  std::string listen_;
  std::filesystem::path data_folder_;
  std::vector<std::string> allowed_hosts_;
  std::optional<CertificateFiles> certificate_;
  AlarmSender* alarms_;
  SettingsDesk* settings_;
  std::unique_ptr<Running> running_;
};

}  // namespace soak::station
