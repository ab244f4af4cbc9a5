// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>

#include "hal/links/detail/byte_source.h"
#include "hal/usb/detail/bulk_stream.h"
#include "hal/usb/detail/usb_context.h"
#include "hal/usb/usb_devices.h"

namespace soak::hal::usb {
namespace {

constexpr std::uint16_t kFtdi = 0x0403;

/// Boards of Xsens that carry a chip of FTDI come under a number of their own.
bool is_ft232(const UsbAddress& address) {
  return address.vendor == kFtdi || (address.vendor == 0x2639 && address.product == 0x0300);
}

class UsbSource final : public imu::ByteSource {
 public:
  explicit UsbSource(const UsbAddress& address) : address_(address) {}
  ~UsbSource() override { close_stream(); }

  base::Status open() override;
  void close() override { close_stream(); }
  base::Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
  base::Result<std::size_t> write(std::span<const std::uint8_t> bytes) override;
  int fd() const override { return stream_ ? stream_->fd() : -1; }
  std::string description() const override { return text_of(address_); }

 private:
  base::Status open_device();
  void close_stream();
  template <class Result>
  Result here(Result result) const {
    if (!result && result.error().where.empty()) result.error().where = description();
    return result;
  }

  UsbAddress address_;
  UsbContext* context_ = nullptr;
  std::shared_ptr<BulkStream> stream_;
  bool stalled_ = false;  ///< when it was closed
};

base::Status UsbSource::open() {
  close_stream();
  return here(open_device());
}

/// Looks anew at what is plugged in: a unit that was unplugged comes back under another number.
base::Status UsbSource::open_device() {
  const auto context = UsbContext::get();
  if (!context) return base::forward_error(context);
  context_ = *context;
  const auto device = find_usb_device(address_);
  if (!device) return base::forward_error(device);
  auto handle = UsbHandle::open(*context_, *device);
  if (!handle) return base::forward_error(handle);
  if (std::exchange(stalled_, false)) (*handle)->clear_halt();
  const bool ft232 = is_ft232(address_);
  if (ft232) {
    if (auto ready = set_up_ft232(**handle, address_.baud); !ready) return ready;
  } else {
    (*handle)->drain();
  }
  stream_ = std::make_shared<BulkStream>(*context_, *std::move(handle), *device,
                                         ft232 ? BulkStream::Framing::ft232 : BulkStream::Framing::plain);
  auto started = stream_->start();
  if (!started) close_stream();
  return started;
}

void UsbSource::close_stream() {
  if (!stream_) return;
  stalled_ = stream_->stalled();
  stream_->stop();
  if (!stream_->finished()) context_->keep_until_finished(std::move(stream_));
  stream_.reset();
}

base::Result<std::size_t> UsbSource::read(std::span<std::uint8_t> buffer) {
  if (!stream_) return base::fail(base::ErrorKind::device, "it is not open", description());
  return here(stream_->read(buffer));
}

base::Result<std::size_t> UsbSource::write(std::span<const std::uint8_t> bytes) {
  if (!stream_) return base::fail(base::ErrorKind::device, "it is not open", description());
  return here(stream_->write(bytes));
}

}  // namespace
}  // namespace soak::hal::usb

namespace soak::hal::imu {

std::unique_ptr<ByteSource> make_usb_source(const UsbAddress& address) {
  return std::make_unique<usb::UsbSource>(address);
}

}  // namespace soak::hal::imu
