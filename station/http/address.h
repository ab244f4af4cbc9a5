// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// Path that all of the interface begins with.
inline constexpr const char* kApiPath = "/api/v1/";

/// Where a daemon listens or is asked: "127.0.0.1:8088", "localhost:8088", "[::1]:8088".
struct HostPort {
  std::string host;  ///< without the brackets of an IPv6 address
  int port = 0;
};

/// Reads HOST:PORT, port 0 to 65535. Refuses (bad_input) anything else, an IPv6 address without brackets included.
[[nodiscard]] base::Result<HostPort> parse_host_port(std::string_view text);

/// The inverse of parse_host_port().
[[nodiscard]] std::string to_text(const HostPort& address);

/// The host of "host", "host:port" or "[address]:port" as a Host header gives it, in small letters, without brackets.
[[nodiscard]] std::string host_of(std::string_view authority);

/// Whether `host` is a numeric IPv4 or IPv6 address, which no name server can point elsewhere.
[[nodiscard]] bool is_numeric_address(const std::string& host);

/// This machine's own name, its first part, and that part as it is called on a local network (RFC 6762):
/// "pc.lab.example", "pc", "pc.local". In small letters; none where it has none.
[[nodiscard]] std::vector<std::string> names_of_machine();

/// What a request says about where it comes from.
struct RequestOrigin {
  std::string host;                   ///< Host header
  std::optional<std::string> origin;  ///< Origin header
  bool tls = false;                   ///< it came over TLS
};

/// How a program reaches a soakd.
struct StationAddress {
  HostPort address;
  bool tls = false;
};

/// Reads HOST:PORT, http://HOST:PORT or https://HOST:PORT; a slash may end it, as in the address of the page. Refuses
/// (bad_input) anything else.
[[nodiscard]] base::Result<StationAddress> parse_station_address(std::string_view text);

/// Whether `listen` is an address that only the machine itself reaches: localhost, 127.x.x.x, ::1.
[[nodiscard]] bool is_loopback(const HostPort& listen);

/// Why a request is refused, or nothing where it may pass. A page of another site can make a browser send requests to
/// this machine; two things give it away:
/// - its own name stands in the Host header (also once a name server points that name here: DNS rebinding). Hosts that
///   pass: those of `names` (the one listened on, this machine's, the configuration's), localhost, 127.0.0.1, [::1];
///   with a wildcard address (0.0.0.0, [::]) among them any numeric one. Ports are not compared: a tunnel may change
///   them;
/// - its own name stands in the Origin header, which must name the same host and port as Host.
[[nodiscard]] std::optional<std::string> why_refused(const RequestOrigin& request,
                                                     const std::vector<std::string>& names);

}  // namespace soak::station
