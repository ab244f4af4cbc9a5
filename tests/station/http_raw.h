// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace soak::station {

/// A connection to 127.0.0.1 that sends what it is told, byte for byte: no HTTP library has its say.
class RawConnection {
 public:
  explicit RawConnection(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{30, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  RawConnection(RawConnection&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)), connected_(other.connected_), text_(std::move(other.text_)) {}
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;
  ~RawConnection() {
    if (socket_ >= 0) ::close(socket_);
  }

  [[nodiscard]] bool connected() const { return connected_; }

  void send(const std::string& text) {
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t n = ::send(socket_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return;
      sent += static_cast<std::size_t>(n);
    }
  }

  /// Reads until `marker` has come `times` times; false where the connection ends or 30 s pass before.
  bool read_until(const std::string& marker, std::size_t times = 1) {
    while (count(marker) < times) {
      if (!read_some()) return false;
    }
    return true;
  }

  /// Reads to the end of the connection; all text so far.
  const std::string& read_all() {
    while (read_some()) {
    }
    return text_;
  }

  [[nodiscard]] const std::string& text() const { return text_; }

  [[nodiscard]] std::size_t count(const std::string& marker) const {
    std::size_t n = 0;
    for (std::size_t at = text_.find(marker); at != std::string::npos; at = text_.find(marker, at + marker.size())) ++n;
    return n;
  }

 private:
  bool read_some() {
    char buffer[4096];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n > 0) text_.append(buffer, static_cast<std::size_t>(n));
    return n > 0;
  }

  int socket_;
  bool connected_ = false;
  std::string text_;
};

/// The whole answer to one request.
inline std::string exchange_raw(int port, const std::string& request) {
  RawConnection connection(port);
  connection.send(request);
  return connection.read_all();
}

inline int status_of(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}

inline std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? std::string() : answer.substr(end + 4);
}

}  // namespace soak::station
