// SPDX-License-Identifier: Apache-2.0
#include "station/http/wire.h"

#include <fcntl.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

namespace soak::station {
namespace {

class ClearWire final : public Wire {
 public:
  explicit ClearWire(int socket) : socket_(socket) {}

  Begin begin() override { return Begin::begun; }
  Moved receive(char* bytes, std::size_t size) override {
    return moved(::recv(socket_, bytes, size, MSG_DONTWAIT), POLLIN);
  }
  Moved send(const char* bytes, std::size_t size) override {
    return moved(::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT), POLLOUT);
  }
  void say_end() override {}

 private:
  static Moved moved(ssize_t n, short waits_for) {
    if (n > 0) return {static_cast<std::size_t>(n), 0};
    return {0, n < 0 && (errno == EAGAIN || errno == EINTR) ? waits_for : short{0}};
  }

  int socket_;
};

struct FreeSession {
  void operator()(SSL* session) const { SSL_free(session); }
};

class TlsWire final : public Wire {
 public:
  TlsWire(int socket, SSL_CTX* context) : socket_(socket), clear_(socket), session_(SSL_new(context)) {
    // OpenSSL reads and writes the socket itself; that it does not wait is a property of the socket.
    ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
    if (session_ && SSL_set_fd(session_.get(), socket) != 1) session_.reset();
  }

  Begin begin() override {
    if (!session_) return Begin::failed;
    if (!heard_) {
      const Begin first = first_byte();
      in_the_clear_ = first == Begin::speaks_http;
      if (first != Begin::begun) return first;
      heard_ = true;
    }
    ERR_clear_error();
    const int result = SSL_accept(session_.get());
    if (result == 1) return open_ = true, Begin::begun;
    const short waits_for = waits_after(result);
    if (waits_for == 0) return Begin::failed;
    return waits_for == POLLIN ? Begin::waits_to_read : Begin::waits_to_write;
  }
  Moved receive(char* bytes, std::size_t size) override {
    if (!open_) return in_the_clear_ ? clear_.receive(bytes, size) : Moved{};
    std::size_t count = 0;
    ERR_clear_error();
    const int result = SSL_read_ex(session_.get(), bytes, size, &count);
    return result == 1 ? Moved{count, 0} : Moved{0, waits_after(result)};
  }
  Moved send(const char* bytes, std::size_t size) override {
    if (!open_) return in_the_clear_ ? clear_.send(bytes, size) : Moved{};
    std::size_t count = 0;
    ERR_clear_error();
    const int result = SSL_write_ex(session_.get(), bytes, size, &count);
    return result == 1 ? Moved{count, 0} : Moved{0, waits_after(result)};
  }
  void say_end() override {
    if (!open_) return;
    ERR_clear_error();
    SSL_shutdown(session_.get());
  }

 private:
  static constexpr unsigned char kHandshake = 22;  // the first byte of a handshake's record: RFC 8446, 5.1

  Begin first_byte() const {
    unsigned char first = 0;
    const ssize_t n = ::recv(socket_, &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return Begin::waits_to_read;
    if (n <= 0) return Begin::failed;
    if (first == kHandshake) return Begin::begun;
    return first >= 'A' && first <= 'Z' ? Begin::speaks_http : Begin::failed;
  }

  /// What a call that has not moved anything waits for; 0 once the connection is over.
  short waits_after(int result) {
    switch (SSL_get_error(session_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        return POLLIN;
      case SSL_ERROR_WANT_WRITE:
        return POLLOUT;
      default:
        open_ = false;  // after some errors nothing may be said any more
        return 0;
    }
  }

  int socket_;
  ClearWire clear_;
  std::unique_ptr<SSL, FreeSession> session_;
  bool heard_ = false;         ///< what the client has sent begins as a handshake does
  bool in_the_clear_ = false;  ///< the client speaks HTTP
  bool open_ = false;          ///< the handshake is done, and no error has come since
};

}  // namespace

std::unique_ptr<Wire> make_wire(int socket, SSL_CTX* tls) {
  if (tls == nullptr) return std::make_unique<ClearWire>(socket);
  return std::make_unique<TlsWire>(socket, tls);
}

}  // namespace soak::station
