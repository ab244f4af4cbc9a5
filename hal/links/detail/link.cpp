// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/link.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace soak::hal {
namespace {

constexpr std::array kPauses_s = {1.0, 2.0, 5.0, 10.0};
constexpr double kTimeoutsPerCall = 5.0;

}  // namespace

void LinkPatience::begin_call() { call_end_ = Clock::now() + clock_time(kTimeoutsPerCall * response_timeout_s_); }

std::optional<std::string> LinkPatience::must_wait() const {
  const auto now = Clock::now();
  if (now >= next_try_) return std::nullopt;
  const std::chrono::duration<double> left = next_try_ - now;
  return fmt::format("{}; next try in {:.1f} s", last_fault_, left.count());
}

void LinkPatience::give_up(std::string reason) {
  last_fault_ = std::move(reason);
  const auto step = std::min(static_cast<std::size_t>(failures_), kPauses_s.size() - 1);
  next_try_ = Clock::now() + clock_time(std::max(kPauses_s[step], response_timeout_s_));
  ++failures_;
}

}  // namespace soak::hal
