// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/file_descriptor.h"
#include "hal/devices/unit_power.h"

namespace soak::hal {
namespace {

namespace fs = std::filesystem;

constexpr int kOutputsPerHub = 100;
constexpr int kMostPorts = 31;  // of a hub, in the kernel

int port_of(int output) { return (output - 1) % kOutputsPerHub + 1; }

std::string hubs_text(const UsbHubs& hubs) { return fmt::format("USB hub {}", fmt::join(hubs.paths, ", ")); }

/// One attribute of a port, `disable` (Linux 6.0): 1 disconnects the device and takes its supply away.
class PortSwitch {
 public:
  explicit PortSwitch(const fs::path& port) : file_(port / "disable") {}

  bool exists() const {
    std::error_code none;
    return fs::exists(file_, none);
  }

  base::Status write(bool on) const {
    const base::FileDescriptor file(::open(file_.c_str(), O_WRONLY | O_CLOEXEC));
    const bool written = file && ::write(file.get(), on ? "0" : "1", 1) == 1;
    return written ? base::Status{} : failed("switch", errno);
  }

  /// What the hub itself says.
  base::Result<bool> is_on() const {
    const base::FileDescriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC));
    std::array<char, 8> text{};
    if (!file || ::read(file.get(), text.data(), text.size()) < 1) return base::forward_error(failed("read", errno));
    return text.front() == '0';
  }

  base::Status may_write() const {
    return ::access(file_.c_str(), W_OK) == 0 ? base::Status{} : failed("switch", errno);
  }

 private:
  base::Status failed(const char* what, int error_number) const {
    const bool forbidden = error_number == EACCES || error_number == EPERM;
    return base::fail(base::ErrorKind::device,
                      forbidden
                          ? fmt::format("no permission to {} the port: install the udev rules (docs/hardware.md)", what)
                          : fmt::format("cannot {} the port: {}", what, std::generic_category().message(error_number)),
                      file_.string());
  }

  fs::path file_;
};

/// The first interface of a hub; of a root hub "usb1" it is called "1-0:1.0".
fs::path interface_of(const std::string& hub, const fs::path& devices) {
  return devices / (hub.starts_with("usb") ? hub.substr(3) + "-0:1.0" : hub + ":1.0");
}

base::Status hub_is_there(const std::string& hub, const fs::path& devices) {
  std::error_code none;
  if (fs::is_directory(interface_of(hub, devices), none)) return {};
  return base::fail(base::ErrorKind::device, "no USB hub is plugged in there", hub);
}

base::Status check_output(const UsbHubs& hubs, int output) {
  const int hub = (output - 1) / kOutputsPerHub;
  if (output >= 1 && hub < static_cast<int>(hubs.paths.size()) && port_of(output) <= kMostPorts) return {};
  return base::bad_input(
      fmt::format(
          "there is no output {}: 1 to {} are the ports of the first hub, {} to {} those of the second, and so on",
          output, kMostPorts, kOutputsPerHub + 1, kOutputsPerHub + kMostPorts),
      hubs_text(hubs));
}

/// That of the port and that of its other half: a socket of USB 3 is two ports, and either feeds it.
base::Result<std::vector<PortSwitch>> switches_of(const UsbHubs& hubs, int output, const fs::path& devices) {
  if (auto known = check_output(hubs, output); !known) return base::forward_error(known);
  const std::string& hub = hubs.paths[static_cast<std::size_t>((output - 1) / kOutputsPerHub)];
  if (auto there = hub_is_there(hub, devices); !there) return base::forward_error(there);
  const fs::path port = interface_of(hub, devices) / fmt::format("{}-port{}", hub, port_of(output));
  std::error_code none;
  if (!fs::is_directory(port, none)) {
    return base::fail(base::ErrorKind::device, fmt::format("the USB hub has no port {}", port_of(output)), hub);
  }
  std::vector<PortSwitch> switches = {PortSwitch(port)};
  if (!switches.front().exists()) {
    return base::fail(base::ErrorKind::device, "this kernel cannot switch ports of USB hubs: it takes Linux 6.0", hub);
  }
  if (PortSwitch peer(port / "peer"); peer.exists()) switches.push_back(std::move(peer));
  return switches;
}

base::Result<bool> any_on(const std::vector<PortSwitch>& switches) {
  for (const PortSwitch& port : switches) {
    const auto on = port.is_on();
    if (!on || *on) return on;
  }
  return false;
}

class UsbHubPower final : public UnitPower {
 public:
  UsbHubPower(UsbHubs hubs, fs::path devices) : hubs_(std::move(hubs)), devices_(std::move(devices)) {}

  base::Status connect() override {
    for (const std::string& hub : hubs_.paths) {
      if (auto there = hub_is_there(hub, devices_); !there) return there;
    }
    return {};
  }

  base::Status check(int output, const SupplySettings& settings) const override {
    if (auto known = check_output(hubs_, output); !known) return known;
    if (!settings.voltage_v && !settings.limit_a) return {};
    return base::bad_input("the port of a USB hub has neither a voltage nor a current limit that can be set",
                           description());
  }

  base::Status prepare(int output, const SupplySettings& settings) override { return check(output, settings); }

  base::Status set(int output, bool on) override {
    const auto switches = switches_of(hubs_, output, devices_);
    if (!switches) return base::forward_error(switches);
    for (const PortSwitch& port : *switches) {
      if (auto written = port.write(on); !written) return written;
    }
    const auto is_on = any_on(*switches);
    if (!is_on) return base::forward_error(is_on);
    if (*is_on == on) return {};
    return base::fail(base::ErrorKind::device, fmt::format("output {} does not switch {}", output, on ? "on" : "off"),
                      description());
  }

  base::Result<std::map<int, OutputReading>> read(const std::vector<int>& outputs) override {
    std::map<int, OutputReading> readings;
    for (const int output : outputs) {
      const auto switches = switches_of(hubs_, output, devices_);
      if (!switches) return base::forward_error(switches);
      const auto is_on = any_on(*switches);
      if (!is_on) return base::forward_error(is_on);
      readings[output].on = *is_on;
    }
    return readings;
  }

  bool measures(int /*output*/) const override { return false; }

  std::string description() const override { return hubs_text(hubs_); }

 private:
  UsbHubs hubs_;
  fs::path devices_;
};

}  // namespace

std::unique_ptr<UnitPower> make_usb_hub_power(const UsbHubs& hubs, const std::filesystem::path& devices) {
  return std::make_unique<UsbHubPower>(hubs, devices);
}

base::Status may_switch(const UsbHubs& hubs, int output, const std::filesystem::path& devices) {
  const auto switches = switches_of(hubs, output, devices);
  if (!switches) return base::forward_error(switches);
  for (const PortSwitch& port : *switches) {
    if (auto able = port.may_write(); !able) return able;
  }
  return {};
}

}  // namespace soak::hal
