// SPDX-License-Identifier: Apache-2.0
// gadget_unit FOLDER RATE_HZ: an Xsens unit behind a real USB device. FOLDER is a mounted FunctionFS of the kernel this
// runs on; once its endpoints are there, it prints "ready" and the device can be bound to a controller. The unit loses
// its power when the device is unbound, and wakes up when it is bound again.
#include <endian.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "tests/hal/xsens_peer.h"

namespace {

using soak::hal::imu::test::Bytes;
using soak::hal::imu::test::ScriptedUnit;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// One vendor interface with a bulk endpoint each way, as a device of full and of high speed.
struct __attribute__((packed)) Interface {
  usb_interface_descriptor interface{};
  usb_endpoint_descriptor_no_audio to_host{};
  usb_endpoint_descriptor_no_audio to_device{};

  explicit Interface(int packet_size) {
    interface.bLength = sizeof interface;
    interface.bDescriptorType = USB_DT_INTERFACE;
    interface.bNumEndpoints = 2;
    interface.bInterfaceClass = USB_CLASS_VENDOR_SPEC;
    set(to_host, 1U | USB_DIR_IN, packet_size);
    set(to_device, 2U | USB_DIR_OUT, packet_size);
  }

 private:
  static void set(usb_endpoint_descriptor_no_audio& endpoint, unsigned address, int packet_size) {
    endpoint.bLength = sizeof endpoint;
    endpoint.bDescriptorType = USB_DT_ENDPOINT;
    endpoint.bEndpointAddress = static_cast<std::uint8_t>(address);
    endpoint.bmAttributes = USB_ENDPOINT_XFER_BULK;
    endpoint.wMaxPacketSize = htole16(static_cast<std::uint16_t>(packet_size));
  }
};

struct __attribute__((packed)) Descriptors {
  usb_functionfs_descs_head_v2 head{};
  __le32 full_speed_count = htole32(3);
  __le32 high_speed_count = htole32(3);
  Interface full_speed{64};
  Interface high_speed{512};
};

int open_or_die(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags);
  if (file < 0) {
    std::perror(path.c_str());
    std::exit(1);
  }
  return file;
}

template <class Block>
void write_or_die(int file, const Block& block) {
  if (::write(file, &block, sizeof block) != static_cast<ssize_t>(sizeof block)) {
    std::perror("descriptors");
    std::exit(1);
  }
}

/// Tells the kernel what the device looks like; its endpoints exist from then on.
int describe(const std::string& folder) {
  const int control = open_or_die(folder + "/ep0", O_RDWR);
  Descriptors descriptors;
  descriptors.head.magic = htole32(FUNCTIONFS_DESCRIPTORS_MAGIC_V2);
  descriptors.head.length = htole32(sizeof descriptors);
  descriptors.head.flags = htole32(FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC);
  write_or_die(control, descriptors);
  usb_functionfs_strings_head strings{};
  strings.magic = htole32(FUNCTIONFS_STRINGS_MAGIC);
  strings.length = htole32(sizeof strings);
  write_or_die(control, strings);
  return control;
}

class GadgetUnit {
 public:
  GadgetUnit(const std::string& folder, double rate_hz)
      : to_host_(open_or_die(folder + "/ep1", O_RDWR)),
        to_device_(open_or_die(folder + "/ep2", O_RDWR)),
        period_(std::chrono::round<Clock::duration>(std::chrono::duration<double>(1.0 / rate_hz))) {
    unit_.ticks_per_packet = static_cast<std::uint32_t>(10000.0 / rate_hz);
  }

  /// Device bound and configured, or no more.
  void plug(bool in) {
    const std::lock_guard lock(mutex_);
    if (in && !plugged_) to_send_ = unit_.restart();
    plugged_ = in;
  }

  [[noreturn]] void listen() {
    for (;;) {
      Bytes heard(512);
      const ssize_t got = ::read(to_device_, heard.data(), heard.size());
      if (got <= 0) {
        std::this_thread::sleep_for(5ms);
        continue;
      }
      heard.resize(static_cast<std::size_t>(got));
      const std::lock_guard lock(mutex_);
      if (!unit_.measuring) next_ = Clock::now();
      const Bytes answer = unit_.take(heard);
      to_send_.insert(to_send_.end(), answer.begin(), answer.end());
    }
  }

  [[noreturn]] void talk() {
    for (;;) {
      const Bytes bytes = due();
      // Bytes that the host no longer takes are lost, as on a cable that was pulled.
      if (bytes.empty() || ::write(to_host_, bytes.data(), bytes.size()) < 0) std::this_thread::sleep_for(1ms);
    }
  }

 private:
  /// Answers, and the packets whose time has come.
  Bytes due() {
    const std::lock_guard lock(mutex_);
    if (!plugged_) return {};
    for (; unit_.measuring && next_ <= Clock::now() && to_send_.size() < 4096; next_ += period_) {
      const Bytes packet = unit_.packet();
      to_send_.insert(to_send_.end(), packet.begin(), packet.end());
    }
    return std::exchange(to_send_, {});
  }

  int to_host_;
  int to_device_;
  Clock::duration period_;
  std::mutex mutex_;
  ScriptedUnit unit_;
  bool plugged_ = false;
  Clock::time_point next_;
  Bytes to_send_;
};

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fputs("usage: gadget_unit FOLDER RATE_HZ\n", stderr);
    return 2;
  }
  const int control = describe(arguments[1]);
  GadgetUnit unit(arguments[1], std::atof(arguments[2]));
  std::puts("ready");
  std::fflush(stdout);
  std::thread([&] { unit.listen(); }).detach();
  std::thread([&] { unit.talk(); }).detach();
  usb_functionfs_event event{};
  while (::read(control, &event, sizeof event) == static_cast<ssize_t>(sizeof event)) {
    if (event.type == FUNCTIONFS_ENABLE) unit.plug(true);
    if (event.type == FUNCTIONFS_DISABLE || event.type == FUNCTIONFS_UNBIND) unit.plug(false);
  }
  std::perror("ep0");
  return 1;
}
