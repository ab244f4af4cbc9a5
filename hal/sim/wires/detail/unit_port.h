// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/bytes.h"
#include "base/result.h"
#include "hal/sim/wires/detail/file_descriptor.h"
#include "hal/sim/wires/detail/poll_set.h"
#include "hal/sim/wires/detail/tcp_listener.h"

namespace soak::hal::sim {

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
  [[nodiscard]] bool connected() const override { return reader_.is_open(); }

 protected:
  [[nodiscard]] int channel() const override { return reader_.get(); }
  void disconnect() override;

 private:
  TcpUnitPort(TcpListener listener, Receiver receive) : UnitPort(std::move(receive)), listener_(std::move(listener)) {}
  void accept_reader();
  [[nodiscard]] bool reader_is_gone() const;

  TcpListener listener_;
  FileDescriptor reader_;
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
  PtyUnitPort(FileDescriptor master, std::string path, Receiver receive)
      : UnitPort(std::move(receive)), master_(std::move(master)), path_(std::move(path)) {}

  FileDescriptor master_;
  std::string path_;
  bool connected_ = false;
};

}  // namespace soak::hal::sim
