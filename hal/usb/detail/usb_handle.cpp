// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/usb_handle.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

namespace soak::hal::usb {
namespace {

using Clock = std::chrono::steady_clock;
using base::ErrorKind;

constexpr unsigned kControlTimeout_ms = 250;
constexpr unsigned kDrainTimeout_ms = 5;
constexpr std::chrono::milliseconds kLongestDrain{500};

struct FreeConfig {
  void operator()(libusb_config_descriptor* config) const { libusb_free_config_descriptor(config); }
};
using Config = std::unique_ptr<libusb_config_descriptor, FreeConfig>;

std::optional<BulkPair> pair_of(const libusb_interface_descriptor& interface) {
  BulkPair pair;
  pair.interface = interface.bInterfaceNumber;
  for (std::uint8_t i = 0; i < interface.bNumEndpoints; ++i) {
    const libusb_endpoint_descriptor& endpoint = interface.endpoint[i];
    if ((endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_BULK) continue;
    if ((endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) == 0) {
      pair.out = endpoint.bEndpointAddress;
    } else {
      pair.in = endpoint.bEndpointAddress;
      pair.packet_size = endpoint.wMaxPacketSize;
    }
  }
  if (pair.in == 0 || pair.out == 0 || pair.packet_size == 0) return std::nullopt;
  return pair;
}

/// Of the first interface that has one; endpoint addresses of the units are not published.
std::optional<BulkPair> first_bulk_pair(libusb_device* device) {
  libusb_config_descriptor* raw = nullptr;
  if (libusb_get_active_config_descriptor(device, &raw) != LIBUSB_SUCCESS) return std::nullopt;
  const Config config(raw);
  for (std::uint8_t i = 0; i < config->bNumInterfaces; ++i) {
    const libusb_interface& interface = config->interface[i];
    if (interface.num_altsetting < 1) continue;
    if (auto pair = pair_of(interface.altsetting[0])) return pair;
  }
  return std::nullopt;
}

std::string why_not_opened(const std::string& node, int error_number) {
  if (error_number == EACCES || error_number == EPERM) {
    return fmt::format("no permission to open {}: install the udev rules (docs/hardware.md) and plug the unit again",
                       node);
  }
  return fmt::format("cannot open {}: {}", node, std::generic_category().message(error_number));
}

}  // namespace

base::Result<std::unique_ptr<UsbHandle>> UsbHandle::open(UsbContext& context, const UsbDevice& device) {
  imu::Descriptor node(::open(device.node.c_str(), O_RDWR | O_CLOEXEC));
  if (!node) return base::fail(ErrorKind::device, why_not_opened(device.node, errno));
  std::unique_ptr<UsbHandle> handle(new UsbHandle(std::move(node)));
  const int code = libusb_wrap_sys_device(context.raw(), handle->node_.get(), &handle->handle_);
  if (code != LIBUSB_SUCCESS) {
    return base::fail(ErrorKind::device, fmt::format("cannot use {}: {}", device.node, text_of_code(code)));
  }
  if (auto claimed = handle->claim(device.node); !claimed) return base::forward_error(claimed);
  return handle;
}

base::Status UsbHandle::claim(const std::string& where) {
  const auto pair = first_bulk_pair(libusb_get_device(handle_));
  if (!pair) return base::fail(ErrorKind::device, fmt::format("{} has no pair of bulk endpoints", where));
  pair_ = *pair;
  libusb_set_auto_detach_kernel_driver(handle_, 1);
  if (const int code = libusb_claim_interface(handle_, pair_.interface); code != LIBUSB_SUCCESS) {
    return base::fail(ErrorKind::device,
                      fmt::format("cannot claim interface {} of {}: {}", pair_.interface, where, text_of_code(code)));
  }
  claimed_ = true;
  return {};
}

UsbHandle::~UsbHandle() {
  if (claimed_) libusb_release_interface(handle_, pair_.interface);
  if (handle_ != nullptr) libusb_close(handle_);
}

base::Status UsbHandle::vendor_request(std::uint8_t request, std::uint16_t value, std::uint16_t index) {
  constexpr std::uint8_t kVendorOut = static_cast<std::uint8_t>(LIBUSB_ENDPOINT_OUT) |
                                      static_cast<std::uint8_t>(LIBUSB_REQUEST_TYPE_VENDOR) |
                                      static_cast<std::uint8_t>(LIBUSB_RECIPIENT_DEVICE);
  const int code = libusb_control_transfer(handle_, kVendorOut, request, value, index, nullptr, 0, kControlTimeout_ms);
  if (code >= 0) return {};
  return base::fail(ErrorKind::device,
                    fmt::format("the device refuses request {:02X} ({:04X}): {}", request, value, text_of_code(code)));
}

void UsbHandle::drain() {
  std::array<std::uint8_t, 4096> buffer;
  const auto size = static_cast<int>(buffer.size() - buffer.size() % pair_.packet_size);
  const auto end = Clock::now() + kLongestDrain;
  int got = 0;
  while (Clock::now() < end &&
         libusb_bulk_transfer(handle_, pair_.in, buffer.data(), size, &got, kDrainTimeout_ms) == LIBUSB_SUCCESS &&
         got > 0) {
  }
}

void UsbHandle::clear_halt() {
  libusb_clear_halt(handle_, pair_.in);
  libusb_clear_halt(handle_, pair_.out);
}

}  // namespace soak::hal::usb
