// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "station/lab/lab.h"

namespace soak::station {

/// The dry way out of the cold: drives the chamber to at least 25 °C, waits until the air and every unit that still
/// tells its temperature are above the room's dew point, then switches heating and cooling off. Goes on trying while
/// the chamber does not answer.
class Warmth {
 public:
  explicit Warmth(double temp_c);

  /// True once the chamber is off and no unit can gather dew.
  [[nodiscard]] bool poll(Lab& lab);
  /// Where it drives to: above the dew point in any case.
  [[nodiscard]] double target_c(const Lab& lab) const;

 private:
  [[nodiscard]] bool drive(Lab& lab);
  [[nodiscard]] bool is_dry(const Lab& lab) const;

  double temp_c_;
  bool driving_ = false;
  std::chrono::steady_clock::time_point next_try_{};
  std::optional<double> warm_since_s_;
};

}  // namespace soak::station
