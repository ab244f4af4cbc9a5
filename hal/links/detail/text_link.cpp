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

/// Many times the longest answer that a controller gives.
constexpr std::size_t kLongestAnswer = 1024;
constexpr std::size_t kMostUnasked = 65536;
constexpr int kTextTries = 3;
constexpr std::chrono::milliseconds kQuiet{100};  ///< after which nothing more belongs to an answer

tl::unexpected<LinkFault> text_fault(std::string why) { return tl::unexpected(LinkFault{std::move(why)}); }

std::unique_ptr<imu::ByteSource> controller_source(const ControllerAddress& address) {
  if (const auto* tcp = std::get_if<TcpAddress>(&address)) return imu::make_tcp_source(*tcp);
  return imu::make_serial_source(std::get<SerialAddress>(address));
}

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

/// The byte of Latin-1 of a character that has two bytes in UTF-8.
char latin_1(std::string_view utf_8) {
  const auto high = static_cast<unsigned char>(utf_8[0]);
  const auto low = static_cast<unsigned char>(utf_8[1]);
  return static_cast<char>((high & 0x03U) << 6U | (low & 0x3FU));
}

/// Waits for an event; false once the deadline is over.
bool wait_for_event(int fd, short event, Link::Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Link::Clock::now());
  if (left.count() <= 0) return false;
  pollfd waiting{fd, event, 0};
  return ::poll(&waiting, 1, static_cast<int>(left.count())) > 0;
}

}  // namespace

TextLink::TextLink(LinkSettings settings)
    : Link(std::move(settings)), source_(controller_source(this->settings().address)) {}

LinkResult TextLink::open_port() {
  if (auto opened = source_->open(); !opened) return text_fault(opened.error().message);
  open_ = true;
  return {};
}

void TextLink::close_port() {
  source_->close();
  open_ = false;
}

LinkResult TextLink::drain() {
  std::array<std::uint8_t, 256> buffer;
  for (std::size_t thrown_away = 0; thrown_away <= kMostUnasked;) {
    const auto count = source_->read(buffer);
    if (!count) return text_fault(count.error().message);
    if (*count == 0) return {};
    thrown_away += *count;
  }
  return text_fault("the other end sends data without being asked");
}

LinkResult TextLink::send(std::string_view line, Clock::time_point deadline) {
  std::span<const std::uint8_t> rest(reinterpret_cast<const std::uint8_t*>(line.data()), line.size());
  while (!rest.empty()) {
    const auto count = source_->write(rest);
    if (!count) return text_fault(count.error().message);
    rest = rest.subspan(*count);
    if (*count == 0 && !wait_for_event(source_->fd(), POLLOUT, deadline))
      return text_fault("the command could not be sent in time");
  }
  return {};
}

LinkAnswer<std::string> TextLink::receive_raw(Clock::time_point deadline) {
  const std::string& line_end = settings().line_end;
  std::string text;
  std::array<std::uint8_t, 256> buffer;
  for (;;) {
    const bool may_be_over = line_end.empty() && !text.empty();
    if (!wait_for_event(source_->fd(), POLLIN, may_be_over ? std::min(deadline, Clock::now() + kQuiet) : deadline)) {
      if (may_be_over) return text;
      return text_fault(text.empty() ? "no answer" : "the answer broke off");
    }
    const auto count = source_->read(buffer);
    if (!count) return text_fault(count.error().message);
    text.append(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*count));
    if (text.size() > kLongestAnswer) return text_fault("the answer does not end");
    // Of controllers that take CR some answer with CR LF: what is left of such an end belongs to no answer.
    if (line_end == "\r" && text.starts_with('\n')) text.erase(0, 1);
    if (!line_end.empty() && text.find(line_end) != std::string::npos) return text;
  }
}

LinkAnswer<std::string> TextLink::receive(Clock::time_point deadline) {
  auto text = receive_raw(deadline);
  if (!text) return text;
  const std::string& line_end = settings().line_end;
  const std::size_t end = line_end.empty() ? text->size() : text->find(line_end);
  const std::string_view rest = std::string_view(*text).substr(end + line_end.size());
  const auto line = from_wire(std::string_view(*text).substr(0, end));
  spoilt_ = !line || !(rest.empty() || (line_end == "\r" && rest == "\n"));
  if (!line) return text_fault("the answer is not text");
  if (spoilt_) return text_fault("two answers came to one question");
  return *line;
}

/// A separator beyond ASCII is one byte there: that of its code point in Latin-1.
std::string TextLink::to_wire(std::string text) const {
  const std::string& separator = settings().separator;
  if (separator.size() == 1) return text;
  const char byte = latin_1(separator);
  for (std::size_t at = text.find(separator); at != std::string::npos; at = text.find(separator, at + 1)) {
    text.replace(at, separator.size(), 1, byte);
  }
  return text;
}

std::optional<std::string> TextLink::from_wire(std::string_view line) const {
  const std::string& separator = settings().separator;
  std::string text;
  for (const char c : line) {
    if (separator.size() > 1 && c == latin_1(separator)) {
      text += separator;
    } else if (is_printable(c)) {
      text += c;
    } else {
      return std::nullopt;
    }
  }
  return text;
}

LinkResult TextLink::put(const std::string& command, Clock::time_point deadline) {
  if (auto drained = drain(); !drained) return drained;
  return send(to_wire(settings().prefix + command) + settings().line_end, deadline);
}

void TextLink::pause_between_commands() const {
  std::this_thread::sleep_until(last_exchange_ + clock_time(settings().gap_s.value_or(0.0)));
}

LinkAnswer<std::string> TextLink::ask(const std::string& command, Spoilt spoilt) {
  for (int attempt = 1;; ++attempt) {
    if (auto able = may_request(); !able) return tl::unexpected(able.error());
    pause_between_commands();
    const auto deadline = Clock::now() + clock_time(settings().response_timeout_s);
    spoilt_ = false;
    auto answer = put(command, deadline).and_then([&] { return receive(deadline); });
    last_exchange_ = Clock::now();
    if (answer) return answer;
    if (!spoilt_ || spoilt == Spoilt::give_up || attempt == kTextTries) {
      give_up(answer.error().text);
      return answer;
    }
    std::this_thread::sleep_for(kQuiet);  // what still comes of it is thrown away before the next question
  }
}

LinkResult TextLink::send_only(const std::string& command) {
  if (auto able = may_request(); !able) return able;
  pause_between_commands();
  auto sent = put(command, Clock::now() + clock_time(settings().response_timeout_s));
  last_exchange_ = Clock::now();
  if (!sent) give_up(sent.error().text);
  return sent;
}

}  // namespace soak::hal
