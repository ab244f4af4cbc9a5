// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace soak::station {

/// So many at once, and one more each time that a while has passed: of what somebody outside can cause as often as he
/// likes, and each of which costs somebody else something. Times are in seconds, of any clock that does not go back.
class Ration {
 public:
  Ration(double most, double one_returns_after_s) : most_(most), left_(most), returns_after_s_(one_returns_after_s) {}

  /// Takes one; false where there is none.
  bool take(double now_s) {
    left_ = std::min(most_, left_ + (now_s - taken_s_) / returns_after_s_);
    taken_s_ = now_s;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  double most_;
  double left_;
  double returns_after_s_;
  double taken_s_ = 0.0;  ///< up to which time `left_` counts
};

}  // namespace soak::station
