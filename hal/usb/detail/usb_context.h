// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb-1.0/libusb.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"

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
  void bury(std::shared_ptr<UsbListener> unfinished);

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
  std::vector<std::shared_ptr<UsbListener>> buried_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace soak::hal::usb
