// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hal/links/detail/byte_source.h"
#include "hal/links/detail/link.h"

namespace soak::hal {

/// A link whose peer answers each line with one line, or takes it in silence where that is agreed. Silence, a broken
/// connection and an answer that is no line of printable ASCII close it. One thread at a time.
///
/// Nothing in an answer says to which question it belongs. Therefore what lies in the buffer is thrown away before each
/// question, a late answer runs out in the pause, and two answers to one question count as none. A complete line that
/// is no text, or two lines, were spoilt on the way: the question is asked again, three times in all. Silence is not:
/// its answer may still come.
class TextLink final : public Link {
 public:
  explicit TextLink(LinkSettings settings);

  [[nodiscard]] bool is_open() const override { return open_; }

  /// What to do about an answer that was spoilt.
  enum class Spoilt : std::uint8_t { ask_again, give_up };

  /// The answer to a command on an open link, without its line end, in UTF-8.
  [[nodiscard]] LinkAnswer<std::string> ask(const std::string& command, Spoilt spoilt = Spoilt::ask_again);
  /// Sends a command that has no answer.
  [[nodiscard]] LinkResult send_only(const std::string& command);

 private:
  [[nodiscard]] LinkResult open_port() override;
  void close_port() override;
  [[nodiscard]] LinkResult drain();
  [[nodiscard]] LinkResult send(std::string_view line, Clock::time_point deadline);
  [[nodiscard]] LinkAnswer<std::string> receive(Clock::time_point deadline);
  /// What came until the line end, with what came after it; until nothing more comes where lines have no end.
  [[nodiscard]] LinkAnswer<std::string> receive_raw(Clock::time_point deadline);
  [[nodiscard]] std::string to_wire(std::string text) const;
  /// A line in UTF-8; nothing where a byte of it is no text.
  [[nodiscard]] std::optional<std::string> from_wire(std::string_view line) const;
  /// After the pause between commands: throws away what was not asked for, then sends a line.
  [[nodiscard]] LinkResult put(const std::string& command, Clock::time_point deadline);
  void pause_between_commands() const;

  std::unique_ptr<imu::ByteSource> source_;
  bool open_ = false;
  bool spoilt_ = false;  ///< the last answer came, and was none
  Clock::time_point last_exchange_{};
};

}  // namespace soak::hal
