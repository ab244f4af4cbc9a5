// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <optional>
#include <utility>

#include "hal/links/detail/descriptor_source.h"

namespace soak::hal::imu {
namespace {

struct BaudRate {
  int baud;
  speed_t code;
};

constexpr std::array kBaudRates = {
    BaudRate{4800, B4800},     BaudRate{9600, B9600},       BaudRate{19200, B19200},     BaudRate{38400, B38400},
    BaudRate{57600, B57600},   BaudRate{115200, B115200},   BaudRate{230400, B230400},   BaudRate{460800, B460800},
    BaudRate{921600, B921600}, BaudRate{1000000, B1000000}, BaudRate{2000000, B2000000}, BaudRate{4000000, B4000000},
};

std::optional<speed_t> code_of(int baud) {
  for (const BaudRate& rate : kBaudRates) {
    if (rate.baud == baud) return rate.code;
  }
  return std::nullopt;
}

std::string all_baud_rates() {
  std::string text;
  for (const BaudRate& rate : kBaudRates) text += fmt::format("{}{}", text.empty() ? "" : ", ", rate.baud);
  return text;
}

/// Raw bytes, 8N1, no flow control, modem lines ignored. Returns whether the line took it.
bool make_raw(int fd, speed_t speed) {
  termios settings{};
  if (::tcgetattr(fd, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
  settings.c_cflag |= CLOCAL | CREAD;
  // With VMIN 0 an idle line would read as 0 bytes, which is what a line that was hung up reads as.
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  ::cfsetispeed(&settings, speed);
  ::cfsetospeed(&settings, speed);
  return ::tcsetattr(fd, TCSANOW, &settings) == 0;
}

class SerialSource final : public DescriptorSource {
 public:
  explicit SerialSource(const SerialAddress& address) : address_(address) {}

  base::Status open() override;
  std::string description() const override {
    return fmt::format("serial {} at {} baud", address_.device, address_.baud);
  }

 private:
  SerialAddress address_;
};

base::Status SerialSource::open() {
  close();
  const auto speed = code_of(address_.baud);
  if (!speed) return base::bad_input("the baud rate must be one of " + all_baud_rates(), description());
  Descriptor line(::open(address_.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line) return broken("cannot open", errno);
  if (!make_raw(line.get(), *speed)) return broken("cannot set up the line", errno);
  ::tcflush(line.get(), TCIFLUSH);
  adopt(std::move(line));
  return {};
}

}  // namespace

std::unique_ptr<ByteSource> make_serial_source(const SerialAddress& address) {
  return std::make_unique<SerialSource>(address);
}

}  // namespace soak::hal::imu
