// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak key new -o FILE [--comment TEXT]
struct KeyNewCommand {
  std::string file;
  std::string comment;
};

/// soak key show FILE
struct KeyShowCommand {
  std::string file;
};

/// soak key sign FILE.soakcal --key FILE
struct KeySignCommand {
  std::string file;
  std::string key;
};

/// soak key verify FILE.soakcal --key FILE.pub | --trusted DIR
struct KeyVerifyCommand {
  std::string file;
  std::string key;      ///< empty: `trusted` is given
  std::string trusted;  ///< folder of public keys
};

[[nodiscard]] base::Status run_key_new(const KeyNewCommand& command, Output& output);
[[nodiscard]] base::Status run_key_show(const KeyShowCommand& command, Output& output);
/// Signs in place, atomically; replaces a signature that is there.
[[nodiscard]] base::Status run_key_sign(const KeySignCommand& command, Output& output);
/// Fails (corrupt) for a file that is damaged, not signed, or not signed by one of the keys.
[[nodiscard]] base::Status run_key_verify(const KeyVerifyCommand& command, Output& output);

}  // namespace soak::station
