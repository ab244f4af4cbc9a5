// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "hal/links/detail/descriptor_source.h"

namespace soak::hal::imu {
namespace {

class RecordedSource final : public DescriptorSource {
 public:
  explicit RecordedSource(const RecordedAddress& address) : address_(address) {}

  base::Status open() override;
  base::Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
  base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) override { return bytes.size(); }
  bool answers() const override { return false; }
  std::string description() const override { return "recording " + address_.file; }

 private:
  RecordedAddress address_;
};

base::Status RecordedSource::open() {
  close();
  Descriptor file(::open(address_.file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return broken("cannot open", errno);
  adopt(std::move(file));
  return {};
}

base::Result<std::size_t> RecordedSource::read(std::span<std::uint8_t> buffer) {
  const ssize_t got = ::read(fd(), buffer.data(), buffer.size());
  if (got < 0) return broken("reading failed", errno);
  if (got == 0) return base::fail(base::ErrorKind::device, kRecordingEnded, description());
  return static_cast<std::size_t>(got);
}

}  // namespace

std::unique_ptr<ByteSource> make_recorded_source(const RecordedAddress& address) {
  return std::make_unique<RecordedSource>(address);
}

}  // namespace soak::hal::imu
