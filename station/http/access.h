// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace soak::station {

/// What a request says about where it comes from.
struct RequestOrigin {
  std::string host;                   ///< Host header
  std::optional<std::string> origin;  ///< Origin header
};

/// Why a request is refused, or nothing where it may pass. A page of another site can make a browser send requests to
/// this machine; two things give it away:
/// - its own name stands in the Host header (also once a name server points that name here: DNS rebinding). Hosts that
///   pass: the one listened on, localhost, 127.0.0.1, [::1]; with a wildcard address (0.0.0.0, [::]) any numeric one.
///   Ports are not compared: a tunnel may change them;
/// - its own name stands in the Origin header, which must name the same host and port as Host.
[[nodiscard]] std::optional<std::string> why_refused(const RequestOrigin& request, const std::string& listen_host);

}  // namespace soak::station
