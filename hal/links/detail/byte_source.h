// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/file_descriptor.h"
#include "base/result.h"
#include "hal/links/addresses.h"

namespace soak::hal::imu {

/// Where a unit's bytes come from and go to. Only open() may wait; after an error of read() or write() the source is to
/// be closed. One thread at a time.
class ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;

  /// Errors: `device` if it cannot be reached, `bad_input` for settings that no such source has.
  [[nodiscard]] virtual base::Status open() = 0;
  virtual void close() = 0;
  /// Takes what is there into `buffer`; 0 = nothing now. Error `device`: the peer has gone.
  [[nodiscard]] virtual base::Result<std::size_t> read(std::span<std::uint8_t> buffer) = 0;
  /// Hands over as many bytes as the kernel takes; 0 = none now. Error `device`: the peer has gone.
  [[nodiscard]] virtual base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) = 0;
  /// Readable when bytes are there or the peer has gone; -1 while closed.
  [[nodiscard]] virtual int fd() const = 0;
  /// Whether somebody at the other end can answer; not so in a recording.
  [[nodiscard]] virtual bool answers() const { return true; }
  [[nodiscard]] virtual std::string description() const = 0;
};

/// TCP client. open() waits for the connection for 1 s at most (and for the resolver, if `host` is a name).
[[nodiscard]] std::unique_ptr<ByteSource> make_tcp_source(const TcpAddress& address);

/// Serial line, 8N1 without flow control, also a pseudo-terminal. open() drops input that was left from before.
[[nodiscard]] std::unique_ptr<ByteSource> make_serial_source(const SerialAddress& address);

/// A device on the bus (hal/usb): its bulk endpoints, or the serial line behind a chip of FTDI. open() takes it from
/// the kernel's driver, which has it back after close().
[[nodiscard]] std::unique_ptr<ByteSource> make_usb_source(const UsbAddress& address);

/// A file of bytes as they once arrived, at the speed of the disk. Does not answer; what is written is dropped. Its end
/// is an error of kind `device`, as that of a connection.
[[nodiscard]] std::unique_ptr<ByteSource> make_recorded_source(const RecordedAddress& address);

[[nodiscard]] std::unique_ptr<ByteSource> make_source(const UnitAddress& address);

/// What all sources on a file descriptor have in common: only opening differs.
class DescriptorSource : public ByteSource {
 public:
  void close() override { descriptor_.reset(); }
  [[nodiscard]] base::Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
  [[nodiscard]] base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] int fd() const override { return descriptor_.get(); }

 protected:
  void adopt(base::FileDescriptor descriptor) { descriptor_ = std::move(descriptor); }
  /// Error `device` that says what failed, where, and why by `error_number` (errno).
  [[nodiscard]] tl::unexpected<base::Error> broken(const std::string& what, int error_number) const;

 private:
  base::FileDescriptor descriptor_;
};

}  // namespace soak::hal::imu
