// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/file_descriptor.h"
#include "base/result.h"

namespace soak::hal::sim {

/// Host time that only rises.
[[nodiscard]] inline std::int64_t host_now_ns() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// What to wait for, and whom to tell. Built anew for each wait.
class PollSet {
 public:
  using Handler = std::function<void(short events)>;

  void add(int fd, short events, Handler handler) {
    entries_.push_back({fd, events, 0});
    handlers_.push_back(std::move(handler));
  }

  /// Waits for at most `timeout_ns` (negative: without limit) and calls the handlers of all descriptors that something
  /// has happened to.
  void wait(std::int64_t timeout_ns) {
    const timespec timeout = {timeout_ns / 1'000'000'000, timeout_ns % 1'000'000'000};
    if (ppoll(entries_.data(), entries_.size(), timeout_ns < 0 ? nullptr : &timeout, nullptr) <= 0) return;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (entries_[i].revents != 0) handlers_[i](entries_[i].revents);
    }
  }

 private:
  std::vector<pollfd> entries_;
  std::vector<Handler> handlers_;
};

/// A TCP port of 127.0.0.1. What it accepts does not block and does not delay small packets.
class TcpListener {
 public:
  /// `port` 0 takes any free one. `send_buffer` limits what the system keeps of unsent bytes; 0 leaves its default.
  /// Errors: a port that cannot be had (bad_input).
  [[nodiscard]] static base::Result<TcpListener> open(int port, int send_buffer = 0);

  [[nodiscard]] int fd() const { return fd_.get(); }
  [[nodiscard]] int port() const { return port_; }
  /// The next connection, not open where there is none.
  [[nodiscard]] base::FileDescriptor accept() const;

 private:
  base::FileDescriptor fd_;
  int port_ = 0;
};

/// The end of a unit's cable: one reader at a time. What the unit sends while nobody reads is lost; a reader's bytes
/// are never dropped, however slow it is.
class UnitPort {
 public:
  using Receiver = std::function<void(std::span<const std::uint8_t>)>;

  explicit UnitPort(Receiver receive) : receive_(std::move(receive)) {}
  UnitPort(const UnitPort&) = delete;
  UnitPort& operator=(const UnitPort&) = delete;
  virtual ~UnitPort() = default;

  /// Looks for a reader that comes or goes without an event.
  virtual void watch() = 0;
  virtual void add_to(PollSet& polls) = 0;
  /// Whether a reader can come without an event, so that watch() must be called now and then.
  [[nodiscard]] virtual bool needs_watching() const = 0;
  [[nodiscard]] virtual bool connected() const = 0;

  /// Bytes from the unit.
  void queue(const base::Bytes& bytes);
  /// Hands on as much as the reader takes now.
  void flush();
  /// Whether a connected reader has left bytes untaken.
  [[nodiscard]] bool has_backlog() const { return !pending_.empty(); }

 protected:
  [[nodiscard]] virtual int channel() const = 0;
  virtual void disconnect() = 0;

  void serve_channel(short events);
  void forget_backlog() { pending_.clear(); }
  void add_channel_to(PollSet& polls);

 private:
  Receiver receive_;
  base::Bytes pending_;
};

/// A TCP port. A second reader is turned away while the first one is alive.
class TcpUnitPort final : public UnitPort {
 public:
  [[nodiscard]] static base::Result<std::unique_ptr<TcpUnitPort>> open(int port, Receiver receive);

  [[nodiscard]] int port() const { return listener_.port(); }
  void watch() override {}
  void add_to(PollSet& polls) override;
  [[nodiscard]] bool needs_watching() const override { return false; }
  [[nodiscard]] bool connected() const override { return static_cast<bool>(reader_); }

 protected:
  [[nodiscard]] int channel() const override { return reader_.get(); }
  void disconnect() override;

 private:
  TcpUnitPort(TcpListener listener, Receiver receive) : UnitPort(std::move(receive)), listener_(std::move(listener)) {}
  void accept_reader();
  [[nodiscard]] bool reader_is_gone() const;

  TcpListener listener_;
  base::FileDescriptor reader_;
};

/// A pseudo-terminal, raw.
class PtyUnitPort final : public UnitPort {
 public:
  /// Errors: no pseudo-terminal to be had (internal).
  [[nodiscard]] static base::Result<std::unique_ptr<PtyUnitPort>> open(Receiver receive);

  /// The device that a reader opens.
  [[nodiscard]] const std::string& path() const { return path_; }
  void watch() override;
  void add_to(PollSet& polls) override;
  [[nodiscard]] bool needs_watching() const override { return !connected_; }
  [[nodiscard]] bool connected() const override { return connected_; }

 protected:
  [[nodiscard]] int channel() const override { return master_.get(); }
  void disconnect() override;

 private:
  PtyUnitPort(base::FileDescriptor master, std::string path, Receiver receive)
      : UnitPort(std::move(receive)), master_(std::move(master)), path_(std::move(path)) {}

  base::FileDescriptor master_;
  std::string path_;
  bool connected_ = false;
};

}  // namespace soak::hal::sim
