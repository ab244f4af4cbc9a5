// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb-1.0/libusb.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "hal/links/detail/byte_source.h"
#include "hal/usb/detail/usb_context.h"
#include "hal/usb/usb_devices.h"

namespace soak::hal::usb {

/// The bulk endpoints that bytes come from and go to.
struct BulkPair {
  int interface = -1;
  std::uint8_t in = 0;
  std::uint8_t out = 0;
  std::size_t packet_size = 64;  ///< of `in`
};

/// An open device whose interface with the first pair of bulk endpoints is claimed. A kernel driver that held it is
/// detached, and has it back when the handle is destroyed (not when the process is killed).
class UsbHandle {
 public:
  /// Errors `device`: the node cannot be opened (message names the missing permission), the device has no bulk pair, or
  /// somebody else has claimed it.
  [[nodiscard]] static base::Result<std::unique_ptr<UsbHandle>> open(UsbContext& context, const UsbDevice& device);

  UsbHandle(const UsbHandle&) = delete;
  UsbHandle& operator=(const UsbHandle&) = delete;
  ~UsbHandle();

  [[nodiscard]] libusb_device_handle* raw() const { return handle_; }
  [[nodiscard]] const BulkPair& pair() const { return pair_; }

  /// A request of the vendor to the device. Not from a callback.
  [[nodiscard]] base::Status vendor_request(std::uint8_t request, std::uint16_t value, std::uint16_t index);
  /// Reads and drops what the device still has from before, for at most half a second. Not from a callback.
  void drain();
  /// Makes a stalled endpoint work again. Not from a callback.
  void clear_halt();

 private:
  explicit UsbHandle(imu::Descriptor node) : node_(std::move(node)) {}
  [[nodiscard]] base::Status claim(const std::string& where);

  imu::Descriptor node_;
  libusb_device_handle* handle_ = nullptr;
  BulkPair pair_;
  bool claimed_ = false;
};

}  // namespace soak::hal::usb
