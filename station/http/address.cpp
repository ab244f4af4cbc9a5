// SPDX-License-Identifier: Apache-2.0
#include "station/http/address.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "base/text.h"

namespace soak::station {
namespace {

bool is_known_host(const std::string& host, const std::vector<std::string>& names) {
  constexpr std::array<std::string_view, 3> kLocal = {"localhost", "127.0.0.1", "::1"};
  const auto is_name = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is_name(host) || std::find(kLocal.begin(), kLocal.end(), host) != kLocal.end()) return true;
  const bool listens_everywhere = is_name("0.0.0.0") || is_name("::");
  return listens_everywhere && is_numeric_address(host);
}

}  // namespace

base::Result<HostPort> parse_host_port(std::string_view text) {
  const auto wrong = [&] {
    return base::bad_input("'" + std::string(text) + "' is not an address: give HOST:PORT, such as 127.0.0.1:8088",
                           "address");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return wrong();
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return wrong();
  }
  const auto port = base::parse_int(text.substr(colon + 1));
  if (host.empty() || !port || *port < 0 || *port > 65535) return wrong();
  return HostPort{std::string(host), static_cast<int>(*port)};
}

base::Result<StationAddress> parse_station_address(std::string_view text) {
  constexpr std::string_view kClear = "http://";
  constexpr std::string_view kTls = "https://";
  const bool tls = text.starts_with(kTls);
  const bool has_scheme = tls || text.starts_with(kClear);
  if (has_scheme) text.remove_prefix(tls ? kTls.size() : kClear.size());
  if (has_scheme && text.ends_with('/')) text.remove_suffix(1);
  auto address = parse_host_port(text);
  if (!address) return base::forward_error(address);
  return StationAddress{*std::move(address), tls};
}

bool is_loopback(const HostPort& listen) {
  return listen.host == "localhost" || listen.host == "::1" ||
         (listen.host.starts_with("127.") && is_numeric_address(listen.host));
}

std::string to_text(const HostPort& address) {
  const bool is_ipv6 = address.host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

std::string host_of(std::string_view authority) {
  if (authority.starts_with('[')) {
    authority = authority.substr(1, authority.find(']') - 1);
  } else {
    authority = authority.substr(0, authority.find(':'));
  }
  std::string host(authority);
  std::transform(host.begin(), host.end(), host.begin(), [](unsigned char c) { return std::tolower(c); });
  return host;
}

bool is_numeric_address(const std::string& host) {
  in6_addr bytes{};
  return ::inet_pton(AF_INET, host.c_str(), &bytes) == 1 || ::inet_pton(AF_INET6, host.c_str(), &bytes) == 1;
}

std::vector<std::string> names_of_machine() {
  std::array<char, 256> buffer{};
  if (::gethostname(buffer.data(), buffer.size() - 1) != 0 || buffer[0] == '\0') return {};
  const std::string name = host_of(buffer.data());
  const std::string first = name.substr(0, name.find('.'));
  return {name, first, first + ".local"};
}

std::optional<std::string> why_refused(const RequestOrigin& request, const std::vector<std::string>& names) {
  if (!is_known_host(host_of(request.host), names)) {
    return "the request is for host '" + request.host + "', which is not one of this station's names or addresses";
  }
  if (request.origin && *request.origin != (request.tls ? "https://" : "http://") + request.host) {
    return "the request comes from a page of '" + *request.origin + "', not from a page of this station";
  }
  return std::nullopt;
}

}  // namespace soak::station
