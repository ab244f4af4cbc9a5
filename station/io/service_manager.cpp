// SPDX-License-Identifier: Apache-2.0
#include "station/io/service_manager.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "base/text.h"

namespace soak::station {
namespace {

constexpr int kPingsPerPeriod = 4;

std::string environment_text(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

}  // namespace

ServiceManager::ServiceManager() : address_(environment_text("NOTIFY_SOCKET")) {
  const bool is_address = address_.starts_with('/') || address_.starts_with('@');
  if (!is_address || address_.size() >= sizeof(sockaddr_un::sun_path)) return;
  if (address_.front() == '@') address_.front() = '\0';
  socket_ = base::FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const std::string watched = environment_text("WATCHDOG_PID");
  const auto period_us = base::parse_int(environment_text("WATCHDOG_USEC"));
  if (!period_us || *period_us <= 0 || (!watched.empty() && watched != std::to_string(::getpid()))) return;
  ping_every_ = std::chrono::microseconds(std::max<std::int64_t>(*period_us / kPingsPerPeriod, 1));
}

void ServiceManager::ready(std::string_view status) const { send(fmt::format("READY=1\nSTATUS={}", status)); }

void ServiceManager::stopping(std::string_view status) const { send(fmt::format("STOPPING=1\nSTATUS={}", status)); }

void ServiceManager::still_alive() {
  const auto now = std::chrono::steady_clock::now();
  if (!ping_every_ || now < next_ping_) return;
  next_ping_ = now + *ping_every_;
  send("WATCHDOG=1");
}

void ServiceManager::send(const std::string& message) const {
  if (!socket_) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), std::begin(to.sun_path));
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  (void)!::sendto(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to),
                  length);
}

}  // namespace soak::station
