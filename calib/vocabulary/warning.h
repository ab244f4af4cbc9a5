// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace soak::calib {

/// Something a user of a result must know. `code` is stable (docs/fit.md lists them), `text` says it in a sentence.
struct Warning {
  std::string code;
  std::string text;
};

}  // namespace soak::calib
