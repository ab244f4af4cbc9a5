// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/detail/usb_context.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iterator>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

namespace soak::hal::usb {

// --- libusb and its event thread

namespace {

/// Without udev's socket (a container) libusb refuses to watch the bus, but works without.
int init_libusb(libusb_context** context) {
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
    if (const int code = init_libusb(&raw); code != LIBUSB_SUCCESS) {
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
  if (!unfinished_.empty()) {
    (void)new (std::nothrow) std::vector<std::shared_ptr<UsbListener>>(std::move(unfinished_));
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
    const auto first =
        std::partition(unfinished_.begin(), unfinished_.end(), [](const auto& one) { return !one->finished(); });
    std::move(first, unfinished_.end(), std::back_inserter(finished));
    unfinished_.erase(first, unfinished_.end());
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

void UsbContext::keep_until_finished(std::shared_ptr<UsbListener> unfinished) {
  const std::lock_guard lock(mutex_);
  unfinished_.push_back(std::move(unfinished));
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

// --- an open device

namespace {

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
    return fmt::format("no permission to open {}: install the udev rules (docs/hardware.md) and plug the unit in again",
                       node);
  }
  return fmt::format("cannot open {}: {}", node, std::generic_category().message(error_number));
}

}  // namespace

base::Result<std::unique_ptr<UsbHandle>> UsbHandle::open(UsbContext& context, const UsbDevice& device) {
  base::FileDescriptor node(::open(device.node.c_str(), O_RDWR | O_CLOEXEC));
  if (!node) return base::fail(base::ErrorKind::device, why_not_opened(device.node, errno));
  std::unique_ptr<UsbHandle> handle(new UsbHandle(std::move(node)));
  const int code = libusb_wrap_sys_device(context.raw(), handle->node_.get(), &handle->handle_);
  if (code != LIBUSB_SUCCESS) {
    return base::fail(base::ErrorKind::device, fmt::format("cannot use {}: {}", device.node, text_of_code(code)));
  }
  if (auto claimed = handle->claim(device.node); !claimed) return base::forward_error(claimed);
  return handle;
}

base::Status UsbHandle::claim(const std::string& where) {
  const auto pair = first_bulk_pair(libusb_get_device(handle_));
  if (!pair) return base::fail(base::ErrorKind::device, fmt::format("{} has no pair of bulk endpoints", where));
  pair_ = *pair;
  libusb_set_auto_detach_kernel_driver(handle_, 1);
  if (const int code = libusb_claim_interface(handle_, pair_.interface); code != LIBUSB_SUCCESS) {
    return base::fail(base::ErrorKind::device,
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
  return base::fail(base::ErrorKind::device,
                    fmt::format("the device refuses request {:02X} ({:04X}): {}", request, value, text_of_code(code)));
}

void UsbHandle::drain() {
  std::array<std::uint8_t, 4096> buffer;
  const auto size = static_cast<int>(buffer.size() - buffer.size() % pair_.packet_size);
  const auto end = std::chrono::steady_clock::now() + kLongestDrain;
  int got = 0;
  while (std::chrono::steady_clock::now() < end &&
         libusb_bulk_transfer(handle_, pair_.in, buffer.data(), size, &got, kDrainTimeout_ms) == LIBUSB_SUCCESS &&
         got > 0) {
  }
}

void UsbHandle::clear_halt() {
  libusb_clear_halt(handle_, pair_.in);
  libusb_clear_halt(handle_, pair_.out);
}

}  // namespace soak::hal::usb
