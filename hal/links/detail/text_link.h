// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "hal/links/detail/byte_source.h"
#include "hal/links/detail/link.h"

namespace soak::hal {

/// A link whose peer answers each line with one line, or takes it in silence where that is agreed. Silence, a broken
/// connection and an answer that is no line of printable ASCII close it. One thread at a time.
///
/// Nothing in an answer says to which question it belongs. Therefore what lies in the buffer is thrown away before each
/// question, a late answer runs out in the pause, and two answers to one question count as none.
class TextLink final : public Link {
 public:
  explicit TextLink(LinkSettings settings);

  [[nodiscard]] bool is_open() const override { return open_; }

  /// The answer to a command on an open link, without its line end.
  [[nodiscard]] LinkAnswer<std::string> ask(const std::string& command);
  /// Sends a command that has no answer.
  [[nodiscard]] LinkResult send_only(const std::string& command);

 private:
  [[nodiscard]] LinkResult open_port() override;
  void close_port() override;
  [[nodiscard]] LinkResult drain();
  [[nodiscard]] LinkResult send(std::string_view line, Clock::time_point deadline);
  [[nodiscard]] LinkAnswer<std::string> receive(Clock::time_point deadline);
  /// After the pause between commands: throws away what was not asked for, then sends a line.
  [[nodiscard]] LinkResult put(const std::string& command, Clock::time_point deadline);
  void pause_between_commands() const;

  std::unique_ptr<imu::ByteSource> source_;
  bool open_ = false;
  Clock::time_point last_exchange_{};
};

}  // namespace soak::hal
