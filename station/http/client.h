// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "station/http/address.h"

namespace soak::station {

/// One server-sent event.
struct ServerEvent {
  std::string type;  ///< "status", "log"
  std::string data;  ///< one JSON document
};

/// Takes a text/event-stream apart (WHATWG HTML, 9.2.6), whatever pieces it arrives in. Lines end with LF, as
/// HttpServer writes them.
class EventParser {
 public:
  /// The events that `piece` completes. Comments and events without data yield none.
  [[nodiscard]] std::vector<ServerEvent> take(std::string_view piece);

 private:
  void take_line(std::string_view line, std::vector<ServerEvent>& complete);

  std::string rest_;  ///< of a line that has not ended yet
  ServerEvent event_;
};

/// How a program gets into a station.
struct StationEntry {
  StationEntry(HostPort in_the_clear) : address(std::move(in_the_clear)) {}
  explicit StationEntry(StationAddress station) : address(std::move(station.address)), tls(station.tls) {}

  HostPort address;
  bool tls = false;
  /// Over TLS: the station's own certificate, and no other one is taken; empty = one that the system trusts, for the
  /// name in the address.
  std::filesystem::path certificate;
  /// Over TLS: whatever certificate is shown is taken. Only for what carries no secret and can do no harm.
  bool any_certificate = false;
  std::string token;  ///< `soak user token`; empty = none
};

/// The other end of HttpServer. Errors: what the daemon answered, with its kind; `device` where no daemon answers, with
/// the address and how to start one, or does not show the certificate that it should.
class Client {
 public:
  /// `answer_s`: how long an answer is waited for; a start checks every device first.
  explicit Client(StationEntry entry, int answer_s = 60) : entry_(std::move(entry)), answer_s_(answer_s) {}

  /// GET `path`, for example "status".
  [[nodiscard]] base::Result<nlohmann::json> get(const std::string& path) const;
  /// POST campaign/`command`.
  [[nodiscard]] base::Result<nlohmann::json> command(const std::string& command, const nlohmann::json& body) const;

  /// Hands on the events of one stream, in the calling thread, until `on_event` returns false (success), `keep_on`,
  /// asked every tenth of a second, does (success), or the stream breaks or cannot be had (error).
  [[nodiscard]] base::Status follow(const std::function<bool(const ServerEvent&)>& on_event,
                                    const std::function<bool()>& keep_on) const;

 private:
  StationEntry entry_;
  int answer_s_;
};

}  // namespace soak::station
