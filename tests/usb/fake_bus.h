// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace soak::hal::usb::test {

/// The bus that this program was started on (tests/usb/bus/main_fake_bus.cpp).
class FakeBus {
 public:
  FakeBus() {
    const char* socket = std::getenv("SOAK_FAKE_BUS");
    if (socket == nullptr) throw std::runtime_error("run me by: umockdev-wrapper fake_usb_bus test_usb");
    socket_ = std::atoi(socket);
  }

  /// Sends one line, returns the line that answers it.
  std::string tell(const std::string& line) const {
    const std::string all = line + "\n";
    if (::write(socket_, all.data(), all.size()) != static_cast<ssize_t>(all.size()))
      throw std::runtime_error("no bus");
    std::string answer;
    for (char c = 0; ::read(socket_, &c, 1) == 1 && c != '\n';) answer += c;
    return answer;
  }

  /// The part "NAME=value" of a device's report.
  [[nodiscard]] std::string report(const std::string& path, const std::string& name) const {
    const std::string all = tell("report " + path);
    const auto begin = all.find(name + "=");
    if (begin == std::string::npos) return "";
    const auto value = begin + name.size() + 1;
    return all.substr(value, all.find(' ', value) - value);
  }

 private:
  int socket_ = -1;
};

/// A device that is plugged in for as long as the object lives, or until it is unplugged.
class Plugged {
 public:
  Plugged(const FakeBus& bus, std::string path, const std::string& what) : bus_(bus), path_(std::move(path)) {
    const std::string answer = bus_.tell("plug " + path_ + " " + what);
    if (answer != "ok") throw std::runtime_error(answer);
  }
  Plugged(const Plugged&) = delete;
  Plugged& operator=(const Plugged&) = delete;
  ~Plugged() { unplug("unplug"); }

  /// "unplug", or "vanish" where no udev tells of it.
  void unplug(const std::string& how) {
    if (plugged_) bus_.tell(how + " " + path_);
    plugged_ = false;
  }
  void tell(const std::string& command, const std::string& arguments) const {
    bus_.tell(command + " " + path_ + " " + arguments);
  }
  [[nodiscard]] std::string report(const std::string& name) const { return bus_.report(path_, name); }

 private:
  const FakeBus& bus_;
  std::string path_;
  bool plugged_ = true;
};

}  // namespace soak::hal::usb::test
