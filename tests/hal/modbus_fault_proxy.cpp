// SPDX-License-Identifier: Apache-2.0
#include "modbus_fault_proxy.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>

namespace soak::hal::test {
namespace {

constexpr std::size_t kMbap = 7;
constexpr int kWait_ms = 20;
constexpr int kMostWaits = 100;

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool send_all(int to, const std::vector<std::uint8_t>& frame) {
  return ::send(to, frame.data(), frame.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(frame.size());
}

/// CRC-16 of Modbus, bit by bit from its definition (polynomial A001, start FFFF).
void append_crc(std::vector<std::uint8_t>& frame) {
  std::uint32_t crc = 0xFFFF;
  for (const std::uint8_t byte : frame) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xA001 : crc >> 1;
  }
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

void pause_ms(int time_ms) { std::this_thread::sleep_for(std::chrono::milliseconds(time_ms)); }

}  // namespace

FaultProxy::FaultProxy(int server_port, Framing framing, int late_ms)
    : framing_(framing), server_port_(server_port), late_ms_(late_ms) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = local(0);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 4) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("the fault proxy cannot listen");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { run(); });
}

FaultProxy::~FaultProxy() {
  stop_ = true;
  thread_.join();
  ::close(listener_);
}

void FaultProxy::spoil(Fault fault, int after, int count) {
  count_ = 0;
  fault_ = fault;
  after_ = after;
  count_ = count;
}

Fault FaultProxy::next_fault() {
  if (count_ == 0) return Fault::none;
  if (after_ > 0) {
    --after_;
    return Fault::none;
  }
  --count_;
  return fault_;
}

void FaultProxy::run() {
  while (!stop_) {
    pollfd waiting{listener_, POLLIN, 0};
    if (::poll(&waiting, 1, 20) != 1) continue;
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    ++connections_;
    serve(client);
    ::close(client);
  }
}

void FaultProxy::serve(int client) {
  const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = local(server_port_);
  const int on = 1;
  ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    bool alive = true;
    while (alive && !stop_) {
      pollfd waiting{client, POLLIN, 0};
      if (::poll(&waiting, 1, 20) == 1) alive = relay(client, server);
    }
  }
  ::close(server);
}

bool FaultProxy::receive(int from, Frame& frame, std::size_t count) const {
  std::size_t got = frame.size();
  frame.resize(got + count);
  // A server that was disturbed may never answer: the connection then ends, and so may the proxy.
  for (int waits = 0; got < frame.size() && waits < kMostWaits && !stop_;) {
    pollfd waiting{from, POLLIN, 0};
    if (::poll(&waiting, 1, kWait_ms) != 1) {
      ++waits;
      continue;
    }
    const ssize_t now = ::recv(from, frame.data() + got, frame.size() - got, 0);
    if (now <= 0) return false;
    got += static_cast<std::size_t>(now);
  }
  return got == frame.size();
}

FaultProxy::Frame FaultProxy::receive_frame(int from, bool request) const {
  Frame frame;
  if (framing_ == Framing::tcp) {
    if (!receive(from, frame, kMbap) || !receive(from, frame, frame[5] - 1U)) return {};
    return frame;
  }
  // RTU: a request has 8 bytes, one of function 16 a byte count and as many more; an answer says its length.
  if (request) {
    if (!receive(from, frame, 7)) return {};
    return receive(from, frame, frame[1] == 16 ? frame[6] + 2U : 1U) ? frame : Frame{};
  }
  if (!receive(from, frame, 3)) return {};
  const std::size_t rest = frame[1] > 0x80 ? 2U : frame[1] == 6 || frame[1] == 16 ? 5U : frame[2] + 2U;
  return receive(from, frame, rest) ? frame : Frame{};
}

bool FaultProxy::relay(int client, int server) {
  const Frame request = receive_frame(client, true);
  if (request.empty() || !send_all(server, request)) return false;
  const Frame frame = receive_frame(server, false);
  if (frame.empty()) return false;
  const bool alive = answer(client, next_fault(), frame);
  last_ = frame;
  return alive;
}

bool FaultProxy::answer(int client, Fault fault, const Frame& frame) {
  switch (fault) {
    case Fault::late:
      pause_ms(late_ms_);
      return send_all(client, frame);
    case Fault::silence:
      return true;
    case Fault::reset: {
      const linger at_once{1, 0};
      ::setsockopt(client, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
      return false;
    }
    case Fault::byte_by_byte:
      for (const std::uint8_t byte : frame) {
        if (!send_all(client, {byte})) return false;
        pause_ms(2);
      }
      return true;
    case Fault::stale:
      return send_all(client, last_) && send_all(client, frame);
    case Fault::twice:
      return send_all(client, frame) && send_all(client, frame);
    default:
      return send_all(client, spoiled(fault, frame));
  }
}

FaultProxy::Frame FaultProxy::spoiled(Fault fault, Frame frame) {
  const std::size_t unit = framing_ == Framing::tcp ? kMbap - 1 : 0;
  if (framing_ == Framing::rtu) frame.resize(frame.size() - 2);
  if (fault == Fault::exception || fault == Fault::busy || fault == Fault::acknowledge) {
    frame[unit + 1] |= 0x80;
    frame[unit + 2] = fault == Fault::busy ? 6 : fault == Fault::acknowledge ? 5 : 4;
    frame.resize(unit + 3);
    if (framing_ == Framing::tcp) frame[5] = 3;
  }
  if (fault == Fault::wrong_unit) ++frame[unit];
  if (fault == Fault::wrong_function) frame[unit + 1] ^= 7;
  if (framing_ == Framing::rtu) append_crc(frame);
  if (fault == Fault::truncated) frame.pop_back();
  if (fault == Fault::garbage) {
    for (std::uint8_t& byte : frame) {
      random_ = random_ * 1664525U + 1013904223U;
      byte = static_cast<std::uint8_t>(random_ >> 24U);
    }
  }
  return frame;
}

}  // namespace soak::hal::test
