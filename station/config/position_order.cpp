// SPDX-License-Identifier: Apache-2.0
#include "station/config/position_order.h"

#include <algorithm>
#include <cstddef>

namespace soak::station {
namespace {

int rotation_of_run(PositionChange change, int run) {
  switch (change) {
    case PositionChange::rotate:
      return run;
    case PositionChange::rotate_and_reverse:
      return run / 2;
    case PositionChange::same:
    case PositionChange::reverse:
      return 0;
  }
  return 0;
}

bool is_reversed(PositionChange change, int run) {
  const bool reverses = change == PositionChange::reverse || change == PositionChange::rotate_and_reverse;
  return reverses && run % 2 == 1;
}

/// Where each axis begins in the order.
std::vector<std::size_t> axis_begins(const std::vector<std::string>& order) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || order[i].back() != order[i - 1].back()) begins.push_back(i);
  }
  return begins;
}

}  // namespace

std::vector<std::string> positions_of_run(const Procedure& procedure, int run) {
  std::vector<std::string> order = procedure.positions;
  const auto begins = axis_begins(order);
  const auto first_axis = static_cast<std::size_t>(rotation_of_run(procedure.position_change, run)) % begins.size();
  std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(begins[first_axis]), order.end());
  if (is_reversed(procedure.position_change, run)) std::reverse(order.begin(), order.end());
  return order;
}

}  // namespace soak::station
