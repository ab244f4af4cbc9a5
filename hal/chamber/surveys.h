// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <thread>

#include "base/result.h"
#include "hal/chamber_survey.h"

namespace soak::hal {

[[nodiscard]] base::Result<ChamberSurvey> survey(const RegisterMap& map);
[[nodiscard]] base::Result<ChamberSurvey> survey(const TextMap& map);

/// Opens the link of a survey where it is closed; after a fault, when its pause is over.
template <class Link>
[[nodiscard]] auto open_again(Link& link) {
  link.begin_call();
  if (!link.is_open()) std::this_thread::sleep_until(link.next_try());
  return link.open();
}

}  // namespace soak::hal
