// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace soak::station {

/// The one question that the operator has to answer before the campaign goes on.
class Prompts {
 public:
  struct Prompt {
    std::int64_t id = 0;
    std::string text;
  };

  void ask(std::string text) {
    open_ = Prompt{++last_id_, std::move(text)};
    answered_ = false;
  }
  /// Whether the open prompt was answered; closes it then.
  [[nodiscard]] bool take_answer() {
    if (!answered_) return false;
    open_.reset();
    answered_ = false;
    return true;
  }
  /// Answers the prompt of that number; false where it is not the open one.
  bool answer(std::int64_t id) {
    if (!open_ || open_->id != id) return false;
    answered_ = true;
    return true;
  }
  void withdraw() { open_.reset(); }
  [[nodiscard]] const std::optional<Prompt>& open() const { return open_; }

 private:
  std::optional<Prompt> open_;
  bool answered_ = false;
  std::int64_t last_id_ = 0;
};

}  // namespace soak::station
