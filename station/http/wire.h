// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/types.h>

#include <cstddef>
#include <memory>

namespace soak::station {

/// How a connection's bytes pass: in the clear or by TLS. No call waits; what it would wait for is said instead, so
/// that the deadlines of the connection hold for a handshake as for everything else. Neither closes the socket.
class Wire {
 public:
  /// What came of one call.
  struct Moved {
    std::size_t bytes = 0;
    short waits_for = 0;  ///< POLLIN or POLLOUT: call again with the same once the socket has it
    /// Neither bytes nor waiting: the connection has ended, or does not speak what it should.
    [[nodiscard]] bool is_over() const { return bytes == 0 && waits_for == 0; }
  };

  virtual ~Wire() = default;

  /// To be repeated until it says that it has begun, before anything else. With somebody who speaks HTTP in the clear
  /// to a wire of TLS it goes on in the clear, so that he can be told.
  enum class Begin { begun, waits_to_read, waits_to_write, speaks_http, failed };
  [[nodiscard]] virtual Begin begin() = 0;

  [[nodiscard]] virtual Moved receive(char* bytes, std::size_t size) = 0;
  [[nodiscard]] virtual Moved send(const char* bytes, std::size_t size) = 0;
  /// Says that nothing more is sent, as far as that goes without waiting.
  virtual void say_end() = 0;
};

/// `tls`: the context of a server (tls_context()), which must outlive the wire; null = in the clear.
[[nodiscard]] std::unique_ptr<Wire> make_wire(int socket, SSL_CTX* tls);

}  // namespace soak::station
