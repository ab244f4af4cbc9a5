// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/links/detail/byte_source.h"

namespace soak::hal::imu {

/// A non-blocking file descriptor that it owns.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { reset(); }

  void reset();
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// What all sources on a file descriptor have in common: only opening differs.
class DescriptorSource : public ByteSource {
 public:
  void close() override { descriptor_.reset(); }
  [[nodiscard]] base::Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
  [[nodiscard]] base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] int fd() const override { return descriptor_.get(); }

 protected:
  void adopt(Descriptor descriptor) { descriptor_ = std::move(descriptor); }
  /// Error `device` that says what failed, where, and why by `error_number` (errno).
  [[nodiscard]] tl::unexpected<base::Error> broken(const std::string& what, int error_number) const;

 private:
  Descriptor descriptor_;
};

}  // namespace soak::hal::imu
