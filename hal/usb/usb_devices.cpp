// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/usb_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include "base/text.h"

namespace soak::hal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "/sys/bus/usb/devices";

std::string attribute(const fs::path& device, const char* name) {
  std::ifstream file(device / name);
  std::string line;
  std::getline(file, line);
  return line;
}

std::optional<std::uint16_t> hex_attribute(const fs::path& device, const char* name) {
  const auto bytes = base::bytes_of_hex<2>(attribute(device, name));
  if (!bytes) return std::nullopt;
  return static_cast<std::uint16_t>((*bytes)[0] << 8U | (*bytes)[1]);
}

/// Nothing for what is no device: interfaces are listed beside them, and one may just be going.
std::optional<UsbDevice> read_device(const fs::path& folder) {
  const auto vendor = hex_attribute(folder, "idVendor");
  const auto product = hex_attribute(folder, "idProduct");
  const auto bus = base::parse_int(attribute(folder, "busnum"));
  const auto number = base::parse_int(attribute(folder, "devnum"));
  if (!vendor || !product || !bus || !number) return std::nullopt;
  UsbDevice device;
  device.vendor = *vendor;
  device.product = *product;
  device.name = attribute(folder, "product");
  device.serial = attribute(folder, "serial");
  device.path = folder.filename().string();
  device.bus = static_cast<int>(*bus);
  device.number = static_cast<int>(*number);
  device.node = fmt::format("/dev/bus/usb/{:03}/{:03}", device.bus, device.number);
  return device;
}

}  // namespace

std::vector<UsbDevice> usb_devices() {
  std::vector<UsbDevice> devices;
  std::error_code failure;
  for (fs::directory_iterator entry(kFolder, failure), end; !failure && entry != end; entry.increment(failure)) {
    if (auto device = read_device(entry->path())) devices.push_back(std::move(*device));
  }
  std::sort(devices.begin(), devices.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return devices;
}

bool matches(const UsbAddress& address, const UsbDevice& device) {
  return address.vendor == device.vendor && address.product == device.product &&
         (address.serial.empty() || address.serial == device.serial) &&
         (address.path.empty() || address.path == device.path);
}

base::Result<UsbDevice> find_usb_device(const UsbAddress& address) {
  std::optional<UsbDevice> found;
  const auto devices = usb_devices();
  for (const UsbDevice& device : devices) {
    if (!matches(address, device)) continue;
    if (found) {
      return base::fail(base::ErrorKind::device,
                        fmt::format("two such devices are plugged in, {} and {}: give usb_serial or usb_path",
                                    found->path, device.path),
                        text_of(address));
    }
    found = device;
  }
  if (!found) return base::fail(base::ErrorKind::device, "it is not plugged in", text_of(address));
  return *std::move(found);
}

}  // namespace soak::hal
