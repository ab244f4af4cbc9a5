// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev-1.0/umockdev.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tests/hal/ahrs400_peer.h"
#include "tests/hal/xsens_peer.h"

/// A device on a bus that does not exist: answers the requests to usbfs as the kernel does with a device behind it.
namespace soak::fake {

using Bytes = std::vector<std::uint8_t>;

/// What is behind the endpoints.
class Gadget {
 public:
  virtual ~Gadget() = default;
  /// Bytes from the host.
  virtual void receive(const Bytes& bytes) = 0;
  /// What the host gets now: one transfer's worth, at most `most` bytes; empty = nothing yet.
  virtual Bytes send(std::size_t most) = 0;
  virtual void control(std::uint8_t /*request*/, std::uint16_t /*value*/, std::uint16_t /*index*/) {}
  /// Bytes of the device descriptor and the configuration.
  [[nodiscard]] virtual Bytes descriptors() const = 0;
  /// For the tests: bytes that the host gets before anything else.
  void say(const Bytes& bytes) { said_.insert(said_.end(), bytes.begin(), bytes.end()); }

 protected:
  Bytes take_said(std::size_t most);
  Bytes said_;
};

/// A unit of Xsens that streams `rate_hz` packets a second by the host's clock; its bulk endpoints belong to the second
/// interface.
[[nodiscard]] std::unique_ptr<Gadget> make_xsens_gadget(std::uint32_t serial, double rate_hz);
/// A chip of FTDI with a Crossbow AHRS400 behind it, full or high speed.
[[nodiscard]] std::unique_ptr<Gadget> make_ft232_gadget(std::uint32_t serial, std::size_t packet_size);

class FakeDevice {
 public:
  explicit FakeDevice(std::unique_ptr<Gadget> gadget) : gadget_(std::move(gadget)) {}

  /// On umockdev's thread.
  bool handle(UMockdevIoctlClient* client);

  // On the thread of the commands.
  void say(const Bytes& bytes);
  void fail_next(int count, int status);
  void ignore_cancels(bool ignore);
  /// Ends what is under way as an unplugging does.
  void unplug();
  /// Counts and states as one line.
  std::string report();

 private:
  struct Urb {
    UMockdevIoctlData* data;
    [[nodiscard]] usbdevfs_urb& urb() const { return *reinterpret_cast<usbdevfs_urb*>(data->data); }
  };

  bool submit(UMockdevIoctlClient* client);
  bool reap(UMockdevIoctlClient* client);
  bool discard(UMockdevIoctlClient* client);
  bool control(UMockdevIoctlClient* client);
  bool drive_interface(UMockdevIoctlClient* client, unsigned long request);
  bool give_back(UMockdevIoctlClient* client);
  void take_out(const Urb& urb);
  void pump();
  void finish(Urb urb, int status, int length);
  static gboolean look_again(gpointer self);

  std::mutex mutex_;
  std::unique_ptr<Gadget> gadget_;
  std::deque<Urb> waiting_;  ///< IN, in the order of their submission
  std::deque<Urb> finished_;
  UMockdevIoctlClient* held_ = nullptr;  ///< a reaper that waits for something to reap
  int held_turns_ = 0;
  std::size_t most_waiting_ = 0;
  int failures_ = 0;
  int failure_status_ = 0;
  bool ignores_cancels_ = false;
  bool gone_ = false;
  bool kernel_driver_ = true;
  int claimed_ = -1;
  int halts_cleared_ = 0;
  std::string controls_;
};

}  // namespace soak::fake
