// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/detail/address_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <string>

namespace soak::hal {

TcpAddress read_host_port(const SettingsTable& link, std::string_view key, std::optional<int> usual_port) {
  constexpr int last_port = 65535;
  const std::string text = link.text(key);
  const std::size_t colon = text.rfind(':');
  TcpAddress address{text.substr(0, colon), usual_port.value_or(0)};
  if (colon != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, failure] = std::from_chars(text.data() + colon + 1, end, address.port);
    if (failure != std::errc{} || stop != end) address.port = 0;
  }
  if (address.host.empty() || address.port < 1 || address.port > last_port) {
    link.refuse(
        key, fmt::format("'link.{}' must be {}\"host:port\", not \"{}\"", key, usual_port ? "\"host\" or " : "", text));
  }
  return address;
}

}  // namespace soak::hal
