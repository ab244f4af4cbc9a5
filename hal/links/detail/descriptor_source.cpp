// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/descriptor_source.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace soak::hal::imu {
namespace {

bool is_not_now(int error_number) {
  return error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == EINTR;
}

/// As write(), but a socket whose peer has gone answers EPIPE instead of raising a signal.
ssize_t write_quietly(int fd, std::span<const std::uint8_t> bytes) {
  const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (sent < 0 && errno == ENOTSOCK) return ::write(fd, bytes.data(), bytes.size());
  return sent;
}

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    reset();
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

void Descriptor::reset() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

base::Result<std::size_t> DescriptorSource::read(std::span<std::uint8_t> buffer) {
  const ssize_t got = ::read(fd(), buffer.data(), buffer.size());
  if (got > 0) return static_cast<std::size_t>(got);
  if (got < 0 && is_not_now(errno)) return 0;
  if (got < 0) return broken("reading failed", errno);
  return base::fail(base::ErrorKind::device, "the other end has closed the connection or was unplugged", description());
}

base::Result<std::size_t> DescriptorSource::write(std::span<const std::uint8_t> bytes) {
  const ssize_t sent = write_quietly(fd(), bytes);
  if (sent >= 0) return static_cast<std::size_t>(sent);
  if (is_not_now(errno)) return 0;
  return broken("writing failed", errno);
}

tl::unexpected<base::Error> DescriptorSource::broken(const std::string& what, int error_number) const {
  return base::fail(base::ErrorKind::device, what + ": " + std::generic_category().message(error_number),
                    description());
}

}  // namespace soak::hal::imu
