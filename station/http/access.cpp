// SPDX-License-Identifier: Apache-2.0
#include "station/http/access.h"

#include <algorithm>
#include <array>

#include "station/http/address.h"

namespace soak::station {
namespace {

bool is_known_host(const std::string& host, const std::string& listen_host) {
  constexpr std::array<std::string_view, 3> kLocal = {"localhost", "127.0.0.1", "::1"};
  if (host == listen_host || std::find(kLocal.begin(), kLocal.end(), host) != kLocal.end()) return true;
  const bool listens_everywhere = listen_host == "0.0.0.0" || listen_host == "::";
  return listens_everywhere && is_numeric_address(host);
}

}  // namespace

std::optional<std::string> why_refused(const RequestOrigin& request, const std::string& listen_host) {
  if (!is_known_host(host_of(request.host), listen_host)) {
    return "the request is for host '" + request.host + "', which this station does not answer to";
  }
  if (request.origin && *request.origin != "http://" + request.host) {
    return "the request comes from a page of '" + *request.origin + "', not from this station's own";
  }
  return std::nullopt;
}

}  // namespace soak::station
