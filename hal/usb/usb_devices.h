// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/links/addresses.h"

namespace soak::hal {

/// A device on the USB bus, as the kernel knows it.
struct UsbDevice {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string name;    ///< product of the device's own descriptor; may be empty
  std::string serial;  ///< may be empty
  std::string path;    ///< of the socket: "1-4.2"
  std::string node;    ///< "/dev/bus/usb/001/005"
  int bus = 0;
  int number = 0;  ///< on the bus; another one after each plugging
};

/// The devices that are plugged in now, from sysfs: needs neither udev nor permissions. In the order of their paths.
[[nodiscard]] std::vector<UsbDevice> usb_devices();

/// Whether the address means the device.
[[nodiscard]] bool matches(const UsbAddress& address, const UsbDevice& device);

/// The device that `address` names. Errors `device`: it is not plugged in, or several are.
[[nodiscard]] base::Result<UsbDevice> find_usb_device(const UsbAddress& address);

}  // namespace soak::hal
