// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "station/http/address.h"

namespace soak::station {

/// One server-sent event.
struct ServerEvent {
  std::string type;  ///< "status", "log"
  std::string data;  ///< one JSON document
};

/// The other end of HttpServer. Errors: what the daemon answered, with its kind; `device` where no daemon answers, with
/// the address and how to start one.
class Client {
 public:
  explicit Client(HostPort address) : address_(std::move(address)) {}

  /// GET `path`, for example "status".
  [[nodiscard]] base::Result<nlohmann::json> get(const std::string& path) const;
  /// POST campaign/`command`.
  [[nodiscard]] base::Result<nlohmann::json> command(const std::string& command, const nlohmann::json& body) const;

  /// Hands on the events of one stream, in the calling thread, until `on_event` returns false (success), `keep_on`,
  /// asked every tenth of a second, does (success), or the stream breaks or cannot be had (error).
  [[nodiscard]] base::Status follow(const std::function<bool(const ServerEvent&)>& on_event,
                                    const std::function<bool()>& keep_on) const;

 private:
  HostPort address_;
};

}  // namespace soak::station
