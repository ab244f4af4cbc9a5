// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <thread>

#include "base/result.h"
#include "hal/devices/chamber_survey.h"

namespace soak::hal {

[[nodiscard]] base::Result<ChamberSurvey> survey(const RegisterMap& map);
[[nodiscard]] base::Result<ChamberSurvey> survey(const TextMap& map);

/// Whether a survey is to go on: behind each fault the link pauses, and all of a map would take minutes where nobody
/// answers.
class FirstAnswer {
 public:
  /// One more question was asked; `answered` also by a refusal.
  void note(bool answered) {
    answered_ = answered_ || answered;
    ++questions_;
  }
  /// Three questions, and no answer to any.
  [[nodiscard]] bool missing() const { return !answered_ && questions_ >= 3; }

 private:
  bool answered_ = false;
  int questions_ = 0;
};

/// Opens the link of a survey where it is closed; after a fault, when its pause is over. The pause is no part of the
/// call.
template <class Link>
[[nodiscard]] auto open_again(Link& link) {
  if (!link.is_open()) std::this_thread::sleep_until(link.next_try());
  link.begin_call();
  return link.open();
}

}  // namespace soak::hal
