// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/block_plan.h"

#include <algorithm>
#include <tuple>

namespace soak::hal {
namespace {

bool extends(const RegisterBlock& block, const RegisterSpan& span, int max_block, bool over_holes) {
  const int end = block.address + block.count;
  const bool near = span.address <= end || over_holes;
  return block.function == span.function && near && span.address + span.count - block.address <= max_block;
}

void extend(RegisterBlock& block, const RegisterSpan& span) {
  const int end = block.address + block.count;
  block.has_holes = block.has_holes || span.address > end;
  block.count = std::max(end, span.address + span.count) - block.address;
  block.names += ", " + span.name;
}

}  // namespace

std::vector<RegisterBlock> plan_blocks(std::vector<RegisterSpan> spans, int max_block, bool over_holes) {
  std::sort(spans.begin(), spans.end(), [](const RegisterSpan& a, const RegisterSpan& b) {
    return std::tie(a.function, a.address) < std::tie(b.function, b.address);
  });
  std::vector<RegisterBlock> blocks;
  for (const RegisterSpan& span : spans) {
    if (!blocks.empty() && extends(blocks.back(), span, max_block, over_holes)) {
      extend(blocks.back(), span);
    } else {
      blocks.push_back({span.function, span.address, span.count, false, span.name});
    }
  }
  return blocks;
}

}  // namespace soak::hal
