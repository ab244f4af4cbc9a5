// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/usb_context.h"

#include <sys/time.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

namespace soak::hal::usb {
namespace {

/// Without udev's socket (a container) libusb refuses to watch the bus, but works without.
int init(libusb_context** context) {
  const int code = libusb_init(context);
  if (code == LIBUSB_SUCCESS) return code;
  libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
  return libusb_init(context);
}

}  // namespace

std::string text_of_code(int code) {
  std::string text = libusb_strerror(static_cast<libusb_error>(code));
  return text + " (" + libusb_error_name(code) + ")";
}

base::Result<UsbContext*> UsbContext::get() {
  static std::mutex mutex;
  static std::unique_ptr<UsbContext> context;
  const std::lock_guard lock(mutex);
  if (!context) {
    libusb_context* raw = nullptr;
    if (const int code = init(&raw); code != LIBUSB_SUCCESS) {
      return base::fail(base::ErrorKind::device, "cannot set up USB: " + text_of_code(code));
    }
    context.reset(new UsbContext(raw));
  }
  return context.get();
}

UsbContext::UsbContext(libusb_context* context) : context_(context) {
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) != 0) {
    has_hotplug_ =
        libusb_hotplug_register_callback(context_, LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0, LIBUSB_HOTPLUG_MATCH_ANY,
                                         LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, on_hotplug, this,
                                         &hotplug_) == LIBUSB_SUCCESS;
  }
  thread_ = std::thread([this] { handle_events(); });
}

UsbContext::~UsbContext() {
  if (has_hotplug_) libusb_hotplug_deregister_callback(context_, hotplug_);
  stop_ = true;
  libusb_interrupt_event_handler(context_);
  thread_.join();
  destroy_finished();
  // What still has transfers under way at the end of the process cannot be closed: libusb would work on freed memory.
  if (!buried_.empty()) {
    (void)new (std::nothrow) std::vector<std::shared_ptr<UsbListener>>(std::move(buried_));
    return;
  }
  libusb_exit(context_);
}

void UsbContext::handle_events() {
  while (!stop_) {
    timeval second{1, 0};
    libusb_handle_events_timeout(context_, &second);
    destroy_finished();
  }
}

void UsbContext::destroy_finished() {
  std::vector<std::shared_ptr<UsbListener>> finished;
  {
    const std::lock_guard lock(mutex_);
    const auto first = std::partition(buried_.begin(), buried_.end(), [](const auto& one) { return !one->finished(); });
    std::move(first, buried_.end(), std::back_inserter(finished));
    buried_.erase(first, buried_.end());
  }
}

void UsbContext::add(UsbListener* listener) {
  const std::lock_guard lock(mutex_);
  listeners_.push_back(listener);
}

void UsbContext::remove(UsbListener* listener) {
  const std::lock_guard lock(mutex_);
  std::erase(listeners_, listener);
}

void UsbContext::bury(std::shared_ptr<UsbListener> unfinished) {
  const std::lock_guard lock(mutex_);
  buried_.push_back(std::move(unfinished));
}

/// libusb still knows the device here, but may be asked for nothing that needs it.
int LIBUSB_CALL UsbContext::on_hotplug(libusb_context* /*context*/, libusb_device* device,
                                       libusb_hotplug_event /*event*/, void* self) {
  auto& own = *static_cast<UsbContext*>(self);
  const int bus = libusb_get_bus_number(device);
  const int number = libusb_get_device_address(device);
  const std::lock_guard lock(own.mutex_);
  for (UsbListener* listener : own.listeners_) listener->device_left(bus, number);
  return 0;
}

}  // namespace soak::hal::usb
