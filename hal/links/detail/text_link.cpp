// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/text_link.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <thread>
#include <utility>

namespace soak::hal {
namespace {

using Fault = tl::unexpected<std::string>;

/// Many times the longest answer that a controller gives.
constexpr std::size_t kLongestAnswer = 1024;
constexpr std::size_t kMostUnasked = 65536;

std::unique_ptr<imu::ByteSource> make_source(const TcpAddress& address) { return imu::make_tcp_source(address); }
std::unique_ptr<imu::ByteSource> make_source(const SerialAddress& address) { return imu::make_serial_source(address); }

std::string address_text(const TcpAddress& address) { return fmt::format("{}:{}", address.host, address.port); }
std::string address_text(const SerialAddress& address) { return address.device; }

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

/// Waits for an event; false once the deadline is over.
bool wait_for(int fd, short event, LinkPatience::Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - LinkPatience::Clock::now());
  if (left.count() <= 0) return false;
  pollfd waiting{fd, event, 0};
  return ::poll(&waiting, 1, static_cast<int>(left.count())) > 0;
}

}  // namespace

TextLink::TextLink(TextLinkSettings settings)
    : settings_(std::move(settings)),
      source_(std::visit([](const auto& address) { return make_source(address); }, settings_.address)),
      patience_(settings_.response_timeout_s) {}

std::string TextLink::address() const {
  return std::visit([](const auto& address) { return address_text(address); }, settings_.address);
}

void TextLink::give_up(std::string reason) {
  source_->close();
  open_ = false;
  patience_.give_up(std::move(reason));
}

tl::expected<void, std::string> TextLink::open() {
  if (open_) return {};
  if (auto reason = patience_.must_wait()) return Fault(*std::move(reason));
  if (auto opened = source_->open(); !opened) {
    give_up(opened.error().message);
    return Fault(patience_.last_fault());
  }
  open_ = true;
  return {};
}

tl::expected<void, std::string> TextLink::drain() {
  std::array<std::uint8_t, 256> buffer;
  for (std::size_t thrown_away = 0; thrown_away <= kMostUnasked;) {
    const auto count = source_->read(buffer);
    if (!count) return Fault(count.error().message);
    if (*count == 0) return {};
    thrown_away += *count;
  }
  return Fault("the other end talks without being asked");
}

tl::expected<void, std::string> TextLink::send(std::string_view line, Clock::time_point deadline) {
  std::span<const std::uint8_t> rest(reinterpret_cast<const std::uint8_t*>(line.data()), line.size());
  while (!rest.empty()) {
    const auto count = source_->write(rest);
    if (!count) return Fault(count.error().message);
    rest = rest.subspan(*count);
    if (*count == 0 && !wait_for(source_->fd(), POLLOUT, deadline))
      return Fault("the command could not be sent in time");
  }
  return {};
}

tl::expected<std::string, std::string> TextLink::receive(Clock::time_point deadline) {
  std::string text;
  std::array<std::uint8_t, 256> buffer;
  std::size_t end = std::string::npos;
  while (end == std::string::npos) {
    if (!wait_for(source_->fd(), POLLIN, deadline)) return Fault(text.empty() ? "no answer" : "the answer broke off");
    const auto count = source_->read(buffer);
    if (!count) return Fault(count.error().message);
    text.append(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*count));
    if (text.size() > kLongestAnswer) return Fault("the answer has no end");
    end = text.find(settings_.line_end);
  }
  if (end + settings_.line_end.size() != text.size()) return Fault("two answers came to one question");
  text.resize(end);
  if (!std::all_of(text.begin(), text.end(), is_printable)) return Fault("the answer is not text");
  return text;
}

tl::expected<void, std::string> TextLink::put(const std::string& command, Clock::time_point deadline) {
  if (auto drained = drain(); !drained) return drained;
  return send(settings_.prefix + command + settings_.line_end, deadline);
}

tl::expected<std::string, std::string> TextLink::exchange(const std::string& command) {
  std::this_thread::sleep_until(last_exchange_ + clock_time(settings_.gap_s));
  const auto deadline = Clock::now() + clock_time(settings_.response_timeout_s);
  if (auto sent = put(command, deadline); !sent) return Fault(std::move(sent.error()));
  auto answer = receive(deadline);
  last_exchange_ = Clock::now();
  return answer;
}

tl::expected<void, std::string> TextLink::may_go_on() {
  if (!open_) return Fault(patience_.last_fault());
  if (!patience_.call_is_over()) return {};
  give_up("answers come too late: a longer 'response_timeout_s' gives the controller more time");
  return Fault(patience_.last_fault());
}

tl::expected<std::string, std::string> TextLink::ask(const std::string& command) {
  if (auto able = may_go_on(); !able) return Fault(std::move(able.error()));
  auto answer = exchange(command);
  if (!answer) give_up(answer.error());
  return answer;
}

tl::expected<void, std::string> TextLink::tell(const std::string& command) {
  if (auto able = may_go_on(); !able) return able;
  std::this_thread::sleep_until(last_exchange_ + clock_time(settings_.gap_s));
  auto sent = put(command, Clock::now() + clock_time(settings_.response_timeout_s));
  last_exchange_ = Clock::now();
  if (!sent) give_up(sent.error());
  return sent;
}

}  // namespace soak::hal
