// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/bus/fake_device.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace soak::fake {
namespace {

constexpr std::uint32_t kCapabilities = 0x1F;
/// The node is a plain file, ready at any time: without a pause the host would ask without end.
constexpr unsigned kPause_ms = 1;
constexpr int kMostTurns = 2;

UMockdevIoctlData* resolve(UMockdevIoctlClient* client, std::size_t size) {
  return umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, size, nullptr);
}

bool done(UMockdevIoctlClient* client, long result, int error = 0) {
  umockdev_ioctl_client_complete(client, result, error);
  return true;
}

}  // namespace

bool FakeDevice::handle(UMockdevIoctlClient* client) {
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      std::memcpy(resolve(client, sizeof kCapabilities)->data, &kCapabilities, sizeof kCapabilities);
      return done(client, 0);
    }
    case USBDEVFS_CONNECTINFO: {
      usbdevfs_connectinfo info{};
      info.devnum = 2;
      std::memcpy(resolve(client, sizeof info)->data, &info, sizeof info);
      return done(client, 0);
    }
    case USBDEVFS_CONTROL:
      return control(client);
    case USBDEVFS_SUBMITURB:
      return submit(client);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(client);
    case USBDEVFS_DISCARDURB:
      return discard(client);
    default:
      return drive_interface(client, request);
  }
}

bool FakeDevice::drive_interface(UMockdevIoctlClient* client, unsigned long request) {
  const std::lock_guard lock(mutex_);
  switch (request) {
    case USBDEVFS_DISCONNECT_CLAIM:
      kernel_driver_ = false;
      claimed_ = static_cast<int>(
          reinterpret_cast<usbdevfs_disconnect_claim*>(resolve(client, sizeof(usbdevfs_disconnect_claim))->data)
              ->interface);
      return done(client, 0);
    case USBDEVFS_CLAIMINTERFACE:
      return kernel_driver_ ? done(client, -1, EBUSY) : done(client, 0);
    case USBDEVFS_RELEASEINTERFACE:
      claimed_ = -1;
      return done(client, 0);
    case USBDEVFS_IOCTL: {
      const auto* command = reinterpret_cast<usbdevfs_ioctl*>(resolve(client, sizeof(usbdevfs_ioctl))->data);
      kernel_driver_ = static_cast<unsigned>(command->ioctl_code) == USBDEVFS_CONNECT;
      return done(client, 0);
    }
    case USBDEVFS_CLEAR_HALT:
      ++halts_cleared_;
      return done(client, 0);
    default:
      return done(client, -1, ENOTTY);
  }
}

/// The one request that libusb makes without a URB: which configuration is active.
bool FakeDevice::control(UMockdevIoctlClient* client) {
  UMockdevIoctlData* data = resolve(client, sizeof(usbdevfs_ctrltransfer));
  const auto* transfer = reinterpret_cast<usbdevfs_ctrltransfer*>(data->data);
  constexpr std::uint8_t kGetConfiguration = 8;
  if (transfer->bRequest != kGetConfiguration) return done(client, -1, EPIPE);
  UMockdevIoctlData* answer =
      umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_ctrltransfer, data), transfer->wLength, nullptr);
  answer->data[0] = 1;
  return done(client, 1);
}

bool FakeDevice::submit(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  if (gone_) return done(client, -1, ENODEV);
  UMockdevIoctlData* data = resolve(client, sizeof(usbdevfs_urb));
  umockdev_ioctl_data_ref(data);
  Urb urb{data};
  const auto size = static_cast<std::size_t>(urb.urb().buffer_length);
  if (size > 0) umockdev_ioctl_data_resolve(data, offsetof(usbdevfs_urb, buffer), size, nullptr);
  const bool in = (urb.urb().endpoint & 0x80U) != 0;
  if (urb.urb().type == USBDEVFS_URB_TYPE_BULK && in) {
    waiting_.push_back(urb);
    most_waiting_ = std::max(most_waiting_, waiting_.size());
  } else {
    take_out(urb);
  }
  pump();
  return done(client, 0);
}

void FakeDevice::take_out(const Urb& urb) {
  const auto* bytes = static_cast<const std::uint8_t*>(urb.urb().buffer);
  const auto size = static_cast<std::size_t>(urb.urb().buffer_length);
  if (urb.urb().type == USBDEVFS_URB_TYPE_CONTROL) {
    std::array<std::uint16_t, 2> words{};
    std::memcpy(words.data(), bytes + 2, 4);
    std::array<char, 32> line{};
    std::snprintf(line.data(), line.size(), "%02x:%02x:%04x:%04x,", bytes[0], bytes[1], words[0], words[1]);
    controls_ += line.data();
    gadget_->control(bytes[1], words[0], words[1]);
    finish(urb, 0, 0);
  } else {
    gadget_->receive(Bytes(bytes, bytes + size));
    finish(urb, 0, static_cast<int>(size));
  }
}

/// Fills what waits with what there is.
void FakeDevice::pump() {
  while (!waiting_.empty() && !gone_) {
    const Urb urb = waiting_.front();
    if (failures_ > 0) {
      --failures_;
      waiting_.pop_front();
      finish(urb, failure_status_, 0);
      continue;
    }
    const Bytes bytes = gadget_->send(static_cast<std::size_t>(urb.urb().buffer_length));
    if (bytes.empty()) return;
    std::copy(bytes.begin(), bytes.end(), static_cast<std::uint8_t*>(urb.urb().buffer));
    waiting_.pop_front();
    finish(urb, 0, static_cast<int>(bytes.size()));
  }
}

void FakeDevice::finish(Urb urb, int status, int length) {
  urb.urb().status = status;
  urb.urb().actual_length = length;
  finished_.push_back(urb);
}

bool FakeDevice::give_back(UMockdevIoctlClient* client) {
  if (finished_.empty()) return false;
  UMockdevIoctlData* place = resolve(client, sizeof(void*));
  umockdev_ioctl_data_set_ptr(place, 0, finished_.front().data);
  umockdev_ioctl_data_unref(finished_.front().data);
  finished_.pop_front();
  return done(client, 0);
}

bool FakeDevice::reap(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  pump();
  if (give_back(client)) return true;
  if (gone_) return done(client, -1, ENODEV);
  held_ = UMOCKDEV_IOCTL_CLIENT(g_object_ref(client));
  held_turns_ = 0;
  GSource* timer = g_timeout_source_new(kPause_ms);
  g_source_set_callback(timer, look_again, this, nullptr);
  g_source_attach(timer, g_main_context_get_thread_default());
  g_source_unref(timer);
  return true;
}

gboolean FakeDevice::look_again(gpointer self) {
  auto& own = *static_cast<FakeDevice*>(self);
  const std::lock_guard lock(own.mutex_);
  own.pump();
  if (!own.give_back(own.held_)) {
    if (++own.held_turns_ < kMostTurns) return G_SOURCE_CONTINUE;
    done(own.held_, -1, own.gone_ ? ENODEV : EAGAIN);
  }
  g_object_unref(own.held_);
  own.held_ = nullptr;
  return G_SOURCE_REMOVE;
}

bool FakeDevice::discard(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  const unsigned long address = *reinterpret_cast<unsigned long*>(umockdev_ioctl_client_get_arg(client)->data);
  if (ignores_cancels_) return done(client, 0);
  const auto found =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const Urb& urb) { return urb.data->client_addr == address; });
  if (found == waiting_.end()) return done(client, -1, EINVAL);
  const Urb urb = *found;
  waiting_.erase(found);
  finish(urb, -ENOENT, 0);
  return done(client, 0);
}

// --- commands

void FakeDevice::say(const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  gadget_->say(bytes);
}

void FakeDevice::fail_next(int count, int status) {
  const std::lock_guard lock(mutex_);
  failures_ = count;
  failure_status_ = status;
}

void FakeDevice::ignore_cancels(bool ignore) {
  const std::lock_guard lock(mutex_);
  ignores_cancels_ = ignore;
  if (ignore) return;
  // What was cancelled meanwhile, or would be, comes back now.
  while (!waiting_.empty()) {
    const Urb urb = waiting_.front();
    waiting_.pop_front();
    finish(urb, -ENOENT, 0);
  }
}

void FakeDevice::unplug() {
  const std::lock_guard lock(mutex_);
  gone_ = true;
  while (!waiting_.empty()) {
    const Urb urb = waiting_.front();
    waiting_.pop_front();
    finish(urb, -ESHUTDOWN, 0);
  }
}

std::string FakeDevice::report() {
  const std::lock_guard lock(mutex_);
  return "most_waiting=" + std::to_string(most_waiting_) + " driver=" + (kernel_driver_ ? "kernel" : "none") +
         " claimed=" + std::to_string(claimed_) + " halts_cleared=" + std::to_string(halts_cleared_) +
         " controls=" + controls_;
}

}  // namespace soak::fake
