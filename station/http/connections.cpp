// SPDX-License-Identifier: Apache-2.0
#include "station/http/connections.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <limits>
#include <list>
#include <mutex>
#include <optional>
#include <string_view>

#include "station/http/bounded_pool.h"
#include "station/http/wire.h"

namespace soak::station {
namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Waits until `socket` has one of `events` or the time is over.
bool wait_for(socket_t socket, short events, Clock::time_point latest) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(latest - Clock::now()).count();
    if (left <= 0) return false;
    pollfd descriptor{socket, events, 0};
    const int ready =
        ::poll(&descriptor, 1, static_cast<int>(std::min<std::int64_t>(left, std::numeric_limits<int>::max())));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

void address_of(const sockaddr_storage& address, std::string& ip, int& port) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const auto* v4 = reinterpret_cast<const sockaddr_in*>(&address);
  const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&address);
  const bool six = address.ss_family == AF_INET6;
  const void* number = six ? static_cast<const void*>(&v6->sin6_addr) : static_cast<const void*>(&v4->sin_addr);
  if (::inet_ntop(address.ss_family, number, text.data(), text.size()) == nullptr) return;
  ip = text.data();
  port = ntohs(six ? v6->sin6_port : v4->sin_port);
}

/// What somebody gets who speaks HTTP where TLS is spoken.
constexpr std::string_view kSpeaksTls =
    "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n"
    "Content-Length: 75\r\n\r\nThis station speaks HTTPS only: write https:// in place of http:// for it.\n";

}  // namespace

/// All open connections, oldest first. Cutting one off is shutdown(): its thread then closes it, so that no descriptor
/// is closed while another thread may name it.
class BoundedListener::Register {
 public:
  explicit Register(std::size_t most_short_ones) : most_short_ones_(most_short_ones) {}

  void add(socket_t socket) {
    const std::lock_guard lock(mutex_);
    entries_.push_back({socket});
    if (all_cut_) cut(entries_.back());
    const auto is_short = [](const Entry& entry) { return !entry.endless && !entry.cut; };
    auto count = static_cast<std::size_t>(std::ranges::count_if(entries_, is_short));
    for (Entry& entry : entries_) {
      if (count <= most_short_ones_) return;
      if (!is_short(entry) || !entry.waits_for_client) continue;
      cut(entry);
      --count;
    }
  }

  /// While it waits for its client it may be cut off for another; else the time that it takes is ours.
  void set_waits_for_client(socket_t socket, bool waits) {
    const std::lock_guard lock(mutex_);
    std::ranges::find(entries_, socket, &Entry::socket)->waits_for_client = waits;
  }

  void set_endless(socket_t socket) {
    const std::lock_guard lock(mutex_);
    std::ranges::find(entries_, socket, &Entry::socket)->endless = true;
  }

  void remove_and_close(socket_t socket) {
    const std::lock_guard lock(mutex_);
    entries_.erase(std::ranges::find(entries_, socket, &Entry::socket));
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
  }

  void cut_all() {
    const std::lock_guard lock(mutex_);
    all_cut_ = true;
    for (Entry& entry : entries_) cut(entry);
  }

 private:
  struct Entry {
    socket_t socket;
    bool endless = false;
    bool cut = false;
    bool waits_for_client = false;
  };
  static void cut(Entry& entry) {
    entry.cut = true;
    ::shutdown(entry.socket, SHUT_RDWR);
  }

  std::mutex mutex_;
  std::list<Entry> entries_;
  std::size_t most_short_ones_;
  bool all_cut_ = false;
};

/// One connection as the library reads and writes it, within the limits: beyond them it looks closed.
class BoundedListener::Connection : public httplib::Stream {
 public:
  Connection(socket_t socket, const ConnectionLimits& limits, Register& all, SSL_CTX* tls)
      : socket_(socket),
        wire_(make_wire(socket, tls)),
        limits_(limits),
        all_(all),
        request_until_(after(limits.request_s)) {}

  /// Whether requests can be read: after the handshake, of a wire that has one.
  bool begin() {
    while (true) {
      const Wire::Begin state = wire_->begin();
      if (state == Wire::Begin::begun) return true;
      if (state == Wire::Begin::speaks_http) static_cast<void>(write(kSpeaksTls.data(), kSpeaksTls.size()));
      const bool waits = state == Wire::Begin::waits_to_read || state == Wire::Begin::waits_to_write;
      if (!waits || !wait_for_client(state == Wire::Begin::waits_to_read ? POLLIN : POLLOUT, request_until_)) {
        return false;
      }
    }
  }

  /// From here on the body is read.
  void head_is_read() { allowed_bytes_ = limits_.head_bytes + limits_.body_bytes; }
  void make_endless() { answer_until_ = Clock::time_point::max(); }

  bool is_readable() const override { return next_ < held_ || wait_for_client(POLLIN, request_until_); }
  bool is_writable() const override {
    pollfd descriptor{socket_, POLLOUT | POLLRDHUP, 0};
    return ::poll(&descriptor, 1, 0) >= 0 && (descriptor.revents & (POLLERR | POLLHUP | POLLRDHUP)) == 0;
  }

  ssize_t read(char* bytes, std::size_t size) override {
    if (next_ == held_ && !refill()) return -1;
    const std::size_t n = std::min(size, held_ - next_);
    std::memcpy(bytes, buffer_.data() + next_, n);
    next_ += n;
    return static_cast<ssize_t>(n);
  }

  ssize_t write(const char* bytes, std::size_t size) override {
    if (!answer_until_) answer_until_ = after(limits_.answer_s);
    const auto latest = std::min(*answer_until_, after(limits_.write_s));
    while (wait_for_client(POLLOUT, latest)) {
      const Wire::Moved moved = wire_->send(bytes, size);
      if (moved.bytes > 0) return static_cast<ssize_t>(moved.bytes);
      if (moved.is_over() || !wait_for_client(moved.waits_for, latest)) return -1;
    }
    return -1;
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    sockaddr_storage address{};
    socklen_t length = sizeof address;
    if (::getpeername(socket_, reinterpret_cast<sockaddr*>(&address), &length) == 0) address_of(address, ip, port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    sockaddr_storage address{};
    socklen_t length = sizeof address;
    if (::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) == 0) address_of(address, ip, port);
  }
  socket_t socket() const override { return socket_; }

  /// Ends the answer and passes over what the client still sends: a socket closed over unread bytes takes the answer
  /// with it.
  void finish() {
    wire_->say_end();
    ::shutdown(socket_, SHUT_WR);
    request_until_ = after(limits_.linger_s);
    allowed_bytes_ = read_bytes_ + limits_.body_bytes;
    while (refill()) {
    }
  }

 private:
  bool wait_for_client(short events, Clock::time_point latest) const {
    pollfd descriptor{socket_, events, 0};
    if (::poll(&descriptor, 1, 0) > 0) return Clock::now() < latest;
    all_.set_waits_for_client(socket_, true);
    const bool ready = wait_for(socket_, events, latest);
    all_.set_waits_for_client(socket_, false);
    return ready;
  }

  bool refill() {
    const std::size_t allowed = std::min(buffer_.size(), allowed_bytes_ - read_bytes_);
    if (allowed == 0) return false;
    while (Clock::now() < request_until_) {
      // Before it waits: a wire may hold more than the socket does.
      const Wire::Moved moved = wire_->receive(buffer_.data(), allowed);
      if (moved.is_over()) return false;
      if (moved.bytes > 0) {
        next_ = 0;
        held_ = moved.bytes;
        read_bytes_ += held_;
        return true;
      }
      if (!wait_for_client(moved.waits_for, request_until_)) return false;
    }
    return false;
  }

  socket_t socket_;
  std::unique_ptr<Wire> wire_;
  const ConnectionLimits& limits_;
  Register& all_;
  Clock::time_point request_until_;
  std::optional<Clock::time_point> answer_until_;  ///< from the first byte of the answer on
  std::size_t allowed_bytes_ = limits_.head_bytes;
  std::size_t read_bytes_ = 0;
  std::array<char, 4096> buffer_{};
  std::size_t next_ = 0;
  std::size_t held_ = 0;
};

thread_local BoundedListener::Connection* BoundedListener::connection_of_thread = nullptr;

BoundedListener::BoundedListener(ConnectionLimits limits, SSL_CTX* tls)
    : limits_(limits), tls_(tls), register_(std::make_unique<Register>(limits.short_ones)) {
  new_task_queue = [this] { return new BoundedPool(limits_.threads, limits_.waiting); };
  set_payload_max_length(limits_.body_bytes);
  set_keep_alive_max_count(1);
  set_tcp_nodelay(true);
}

BoundedListener::~BoundedListener() = default;

void BoundedListener::Get(const std::string& path, Handler handler) {
  routes_.push_back({"GET", path});
  httplib::Server::Get(path, std::move(handler));
}

void BoundedListener::Post(const std::string& path, Handler handler) {
  routes_.push_back({"POST", path});
  httplib::Server::Post(path, std::move(handler));
}

void BoundedListener::make_endless() {
  connection_of_thread->make_endless();
  register_->set_endless(connection_of_thread->socket());
}

void BoundedListener::widen_backlog() { ::listen(svr_sock_, static_cast<int>(limits_.threads)); }

void BoundedListener::cut_all() { register_->cut_all(); }

bool BoundedListener::process_and_close_socket(socket_t socket) {
  register_->add(socket);
  Connection connection(socket, limits_, *register_, tls_);
  bool closed = false;
  const auto take_head = [&](httplib::Request& request) {
    connection.head_is_read();
    // A server may pass over the header Range (RFC 9110, 14.2). The library would cut refusals and pages by it, into as
    // many parts as a client asks for.
    request.ranges.clear();
  };
  connection_of_thread = &connection;
  const bool answered = connection.begin() && process_request(connection, true, closed, take_head);
  connection_of_thread = nullptr;
  connection.finish();
  register_->remove_and_close(socket);
  return answered;
}

}  // namespace soak::station
