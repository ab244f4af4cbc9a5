// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <httplib.h>
#include <openssl/types.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace soak::station {

/// Limits of one HTTP connection and of all of them together: whoever sends slowly, much or often shall not keep others
/// from commanding the station, nor take the descriptors that its devices need.
struct ConnectionLimits {
  std::size_t threads = 160;  ///< at work at a time; those that the event streams hold among them
  /// Connections but event streams. For one more the oldest is cut off of those that wait for their client, to send or
  /// to read on: a command that is being carried out keeps its answer.
  std::size_t short_ones = 64;
  std::size_t waiting = 32;        ///< accepted, without a thread yet; more are not accepted until one is free
  std::size_t head_bytes = 65536;  ///< request line and headers
  std::size_t body_bytes = 1 << 20;
  double request_s = 10.0;  ///< from the connection to the end of the request, the handshake of TLS included
  double answer_s = 60.0;   ///< from the first byte of the answer to its end, event streams apart
  double write_s = 5.0;     ///< without any progress of an answer
  double linger_s = 1.0;    ///< after the answer, for what the client still sends
};

/// What the server answers to: a method and the pattern of its paths.
struct Route {
  std::string method;
  std::string path;
};

/// httplib's server with these limits. The library bounds one line of a header and the pause between two bytes, but
/// neither the sum of all headers nor the time of a request nor the number of connections. One request a connection: an
/// idle connection holds no thread, and no part of a refused request can be taken for the next one.
class BoundedListener : public httplib::Server {
 public:
  /// `tls`: context that connections speak TLS with (tls_context()), which must outlive the listener; null = in the
  /// clear.
  explicit BoundedListener(ConnectionLimits limits, SSL_CTX* tls = nullptr);
  ~BoundedListener() override;

  /// The library's own, remembered in routes().
  void Get(const std::string& path, Handler handler);
  void Post(const std::string& path, Handler handler);
  [[nodiscard]] const std::vector<Route>& routes() const { return routes_; }

  /// For a handler, in the thread that called it: the answer that it gives goes on until the client leaves (an event
  /// stream). From here on the connection counts as no short one and its answer has no end.
  void make_endless();

  /// Lets as many connections wait in the kernel as there are threads: the library's five are less than a dozen browser
  /// tabs.
  void widen_backlog();
  /// Cuts off all connections, so that stop() returns at once.
  void cut_all();

 private:
  class Connection;
  class Register;

  static thread_local Connection* connection_of_thread;  ///< that it reads and answers

  bool process_and_close_socket(socket_t socket) override;

  ConnectionLimits limits_;
  SSL_CTX* tls_;
  std::unique_ptr<Register> register_;
  std::vector<Route> routes_;
};

}  // namespace soak::station
