// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb-1.0/libusb.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/file_descriptor.h"
#include "base/result.h"
#include "hal/links/detail/byte_source.h"
#include "hal/usb/usb_devices.h"

namespace soak::hal::usb {

/// What a libusb code means, for messages to the user.
[[nodiscard]] std::string text_of_code(int code);

/// What wants to know that a device has left the bus, and may be in the way of its end.
class UsbListener {
 public:
  virtual ~UsbListener() = default;
  /// The device with this number on this bus has left it. On the event thread: returns at once, calls nothing of
  /// libusb.
  virtual void device_left(int bus, int number) = 0;
  /// Nothing of it is under way any more: it may be destroyed.
  [[nodiscard]] virtual bool finished() const = 0;
};

/// libusb with its one event thread, in which all transfers end. The process has one, made when it is first needed.
///
/// Devices are found by sysfs (hal/usb/usb_devices.h) and opened by their nodes, so that none of this needs udev; where
/// udev runs, libusb's hot-plug tells at once that a device has left, else the transfers tell it.
class UsbContext {
 public:
  /// Error `device` if libusb cannot be set up.
  [[nodiscard]] static base::Result<UsbContext*> get();

  UsbContext(const UsbContext&) = delete;
  UsbContext& operator=(const UsbContext&) = delete;
  ~UsbContext();

  [[nodiscard]] libusb_context* raw() const { return context_; }

  void add(UsbListener* listener);
  void remove(UsbListener* listener);
  /// Takes over what is not finished yet and destroys it on the event thread once it is.
  void keep_until_finished(std::shared_ptr<UsbListener> unfinished);

 private:
  explicit UsbContext(libusb_context* context);
  void handle_events();
  void destroy_finished();
  static int LIBUSB_CALL on_hotplug(libusb_context*, libusb_device* device, libusb_hotplug_event, void* self);

  libusb_context* context_;
  libusb_hotplug_callback_handle hotplug_ = 0;
  bool has_hotplug_ = false;
  std::mutex mutex_;
  std::vector<UsbListener*> listeners_;
  std::vector<std::shared_ptr<UsbListener>> unfinished_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

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
  explicit UsbHandle(base::FileDescriptor node) : node_(std::move(node)) {}
  [[nodiscard]] base::Status claim(const std::string& where);

  base::FileDescriptor node_;
  libusb_device_handle* handle_ = nullptr;
  BulkPair pair_;
  bool claimed_ = false;
};

}  // namespace soak::hal::usb
