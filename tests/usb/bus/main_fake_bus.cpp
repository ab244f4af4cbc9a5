// SPDX-License-Identifier: Apache-2.0
// Plays a USB bus (umockdev) for the program that it starts, and obeys the lines that come over the socket whose number
// the program finds in SOAK_FAKE_BUS. Each line has one as its answer.
//   umockdev-wrapper fake_bus PROGRAM ARGUMENT...
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>
#include <string>

#include "tests/usb/bus/fake_device.h"

namespace soak::fake {
namespace {

struct Plugged {
  std::string syspath;
  std::string node;
  std::unique_ptr<FakeDevice> device;
  UMockdevIoctlBase* handler = nullptr;
};

gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer device) {
  return static_cast<FakeDevice*>(device)->handle(client) ? TRUE : FALSE;
}

std::string hex_of(const Bytes& bytes) {
  std::string text;
  std::array<char, 3> digits{};
  for (const std::uint8_t byte : bytes) {
    std::snprintf(digits.data(), digits.size(), "%02X", byte);
    text += digits.data();
  }
  return text;
}

class Bus {
 public:
  explicit Bus(UMockdevTestbed* testbed) : testbed_(testbed) {}

  std::string obey(const std::string& line) {
    std::istringstream words(line);
    std::string command;
    std::string path;
    words >> command >> path;
    if (command == "plug") return plug(path, words);
    const auto found = plugged_.find(path);
    if (found == plugged_.end()) return "no such device";
    FakeDevice& device = *found->second.device;
    if (command == "unplug" || command == "vanish") return unplug(found->second, path, command == "unplug");
    if (command == "announce") {
      umockdev_testbed_uevent(testbed_, found->second.syspath.c_str(), "remove");
      return "ok";
    }
    if (command == "say") {
      std::string rest;
      std::getline(words, rest);
      device.say(hal::imu::test::hex(rest.substr(1)));
      return "ok";
    }
    int number = 0;
    int status = 0;
    words >> number >> status;
    if (command == "fail") device.fail_next(number, status);
    if (command == "ignore_cancels") device.ignore_cancels(number != 0);
    return command == "report" ? device.report() : "ok";
  }

 private:
  /// plug PATH KIND SERIAL NUMBER: for xsens the rate, for ft232 the packet size.
  std::string plug(const std::string& path, std::istringstream& words) {
    std::string kind;
    std::uint32_t serial = 0;
    double number = 0.0;
    words >> kind >> serial >> number;
    auto gadget = kind == "xsens" ? make_xsens_gadget(serial, number)
                                  : make_ft232_gadget(serial, static_cast<std::size_t>(number));
    ++number_;
    Plugged plugged;
    plugged.syspath = "/sys/devices/pci0000:00/0000:00:14.0/usb1/" + path;
    std::array<char, 64> name{};
    std::snprintf(name.data(), name.size(), "bus/usb/001/%03d", number_);
    plugged.node = std::string("/dev/") + name.data();
    std::ostringstream text;
    text << "P: /devices/pci0000:00/0000:00:14.0/usb1/" << path << "\nN: " << name.data() << "="
         << hex_of(gadget->descriptors()) << "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DEVNAME=" << plugged.node
         << "\nE: BUSNUM=001\nE: DEVNUM=" << name.data() + 12 << "\nE: MAJOR=189\nE: MINOR=" << number_ - 1
         << "\nA: busnum=1\\n\nA: devnum=" << number_ << "\\n\nA: idVendor=" << (kind == "xsens" ? "2639" : "0403")
         << "\\n\nA: idProduct=" << (kind == "xsens" ? "0013" : "6001") << "\\n\nA: product=Fake " << kind
         << "\\n\nA: serial=" << serial
         << "\\n\nA: bConfigurationValue=1\\n\nA: speed=12\\n\nH: descriptors=" << hex_of(gadget->descriptors())
         << "\n\n";
    plugged.device = std::make_unique<FakeDevice>(std::move(gadget));
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed_, text.str().c_str(), &error)) return error->message;
    plugged.handler = umockdev_ioctl_base_new();
    g_signal_connect(plugged.handler, "handle-ioctl", G_CALLBACK(on_ioctl), plugged.device.get());
    if (!umockdev_testbed_attach_ioctl(testbed_, plugged.node.c_str(), plugged.handler, &error)) return error->message;
    umockdev_testbed_uevent(testbed_, plugged.syspath.c_str(), "add");
    plugged_[path] = std::move(plugged);
    return "ok";
  }

  /// With or without a word of udev. The device's memory stays: requests to it may still be under way.
  std::string unplug(Plugged& plugged, const std::string& path, bool announced) {
    plugged.device->unplug();
    if (announced) umockdev_testbed_uevent(testbed_, plugged.syspath.c_str(), "remove");
    g_usleep(50'000);
    umockdev_testbed_remove_device(testbed_, plugged.syspath.c_str());
    graveyard_.push_back(std::move(plugged));
    plugged_.erase(path);
    return "ok";
  }

  UMockdevTestbed* testbed_;
  int number_ = 1;
  std::map<std::string, Plugged> plugged_;
  std::vector<Plugged> graveyard_;
};

int serve(UMockdevTestbed* testbed, int socket, pid_t program) {
  Bus bus(testbed);
  std::string pending;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = ::read(socket, buffer.data(), buffer.size())) > 0;) {
    pending.append(buffer.data(), static_cast<std::size_t>(got));
    for (auto end = pending.find('\n'); end != std::string::npos; end = pending.find('\n')) {
      const std::string answer = bus.obey(pending.substr(0, end)) + "\n";
      (void)!::write(socket, answer.data(), answer.size());
      pending.erase(0, end + 1);
    }
  }
  int status = 0;
  ::waitpid(program, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace
}  // namespace soak::fake

int main(int argc, char** argv) {
  std::array<int, 2> ends{};
  if (argc < 2 || ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) return 2;
  // Puts itself into the environment of what is started from here on.
  UMockdevTestbed* testbed = umockdev_testbed_new();
  const pid_t program = ::fork();
  if (program == 0) {
    ::close(ends[0]);
    ::setenv("SOAK_FAKE_BUS", std::to_string(ends[1]).c_str(), 1);
    ::execv(argv[1], argv + 1);
    std::perror(argv[1]);
    ::_exit(127);
  }
  ::close(ends[1]);
  const int status = soak::fake::serve(testbed, ends[0], program);
  g_object_unref(testbed);
  return status;
}
