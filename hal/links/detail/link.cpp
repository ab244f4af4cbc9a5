// SPDX-License-Identifier: Apache-2.0
#include "hal/links/detail/link.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace soak::hal {
namespace {

constexpr std::array kPauses_s = {1.0, 2.0, 5.0, 10.0};
constexpr double kTimeoutsPerCall = 5.0;

}  // namespace

void Link::begin_call() { call_end_ = Clock::now() + clock_time(kTimeoutsPerCall * settings_.response_timeout_s); }

LinkResult Link::open() {
  if (auto usable = check_use(); !usable) return usable;
  if (is_open()) return {};
  if (const std::chrono::duration<double> left = next_try_ - Clock::now(); left.count() > 0.0) {
    return tl::unexpected(LinkFault{fmt::format("{}; next try in {:.1f} s", last_fault_, left.count())});
  }
  auto opened = open_port();
  if (!opened) give_up(opened.error().text);
  return opened;
}

void Link::give_up(std::string reason) {
  close_port();
  last_fault_ = std::move(reason);
  const auto step = std::min(static_cast<std::size_t>(failures_), kPauses_s.size() - 1);
  next_try_ = Clock::now() + clock_time(std::max(kPauses_s[step], settings_.response_timeout_s));
  ++failures_;
}

LinkResult Link::may_request() {
  if (auto usable = check_use(); !usable) return usable;
  if (!is_open()) return last_fault();
  if (Clock::now() < call_end_) return {};
  give_up("answers come too late: a longer 'response_timeout_s' gives the controller more time");
  return last_fault();
}

}  // namespace soak::hal
