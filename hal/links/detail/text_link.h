// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "hal/links/detail/byte_source.h"
#include "hal/links/detail/link.h"
#include "hal/maps/text_map.h"

namespace soak::hal {

/// A link whose peer answers each line with one line, or takes it in silence where that is agreed. Like ModbusLink it
/// never repairs itself within a call: silence, a broken connection and an answer that is no line of printable ASCII
/// close it, and open() refuses to try again before a pause is over. Errors are texts for the user. One thread at a
/// time.
///
/// Nothing in an answer says to which question it belongs. Therefore what lies in the buffer is thrown away before each
/// question, a late answer runs out in the pause, and two answers to one question count as none.
class TextLink {
 public:
  explicit TextLink(TextLinkSettings settings);

  [[nodiscard]] bool is_open() const { return open_; }
  void begin_call() { patience_.begin_call(); }
  [[nodiscard]] tl::expected<void, std::string> open();
  void confirm() { patience_.confirm(); }
  void give_up(std::string reason);
  [[nodiscard]] LinkPatience::Clock::time_point next_try() const { return patience_.next_try(); }

  /// The answer to a command on an open link, without its line end.
  [[nodiscard]] tl::expected<std::string, std::string> ask(const std::string& command);
  /// Sends a command that has no answer.
  [[nodiscard]] tl::expected<void, std::string> tell(const std::string& command);

  /// "host:port" or the serial device.
  [[nodiscard]] std::string address() const;

 private:
  using Clock = LinkPatience::Clock;

  [[nodiscard]] tl::expected<void, std::string> drain();
  [[nodiscard]] tl::expected<void, std::string> send(std::string_view line, Clock::time_point deadline);
  [[nodiscard]] tl::expected<std::string, std::string> receive(Clock::time_point deadline);
  /// Whether the present call may go on.
  [[nodiscard]] tl::expected<void, std::string> may_go_on();
  /// Throws away what was not asked for, then sends a line.
  [[nodiscard]] tl::expected<void, std::string> put(const std::string& command, Clock::time_point deadline);
  [[nodiscard]] tl::expected<std::string, std::string> exchange(const std::string& command);

  TextLinkSettings settings_;
  std::unique_ptr<imu::ByteSource> source_;
  bool open_ = false;
  LinkPatience patience_;
  Clock::time_point last_exchange_{};
};

}  // namespace soak::hal
