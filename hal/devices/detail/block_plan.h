// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace soak::hal {

/// Registers that belong together and are read by one request.
struct RegisterSpan {
  int function = 3;
  int address = 0;
  int count = 1;
  std::string name;  ///< of what they carry, for messages
};

/// One request: registers from `address` on, for the spans in it.
struct RegisterBlock {
  int function = 3;
  int address = 0;
  int count = 0;
  bool has_holes = false;  ///< it covers registers that nobody asked for
  std::string names;
};

/// Groups spans into as few requests of at most `max_block` registers as their order allows; no span is torn apart.
/// Without `over_holes` a request covers only registers that were asked for.
[[nodiscard]] std::vector<RegisterBlock> plan_blocks(std::vector<RegisterSpan> spans, int max_block, bool over_holes);

}  // namespace soak::hal
