// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "station/lab/lab.h"

namespace soak::station {

/// The dry way out of the cold: drives the chamber to at least 25 °C, waits until the air and every unit that still
/// tells its temperature are above the room's dew point, then switches heating and cooling off. Goes on trying while
/// the chamber does not answer.
///
/// A chamber that answers but does not take the set point (a limit at its front, somebody else who commands it) must
/// not go on heating or cooling for ever: after a few tries heating and cooling are switched off, which is written to
/// the log, and the warmth of the room takes the chamber's place. It is told again once a minute: controllers keep set
/// points in memory that wears out.
class Warmth {
 public:
  explicit Warmth(double temp_c);

  /// True once the chamber is off and no unit can gather dew.
  [[nodiscard]] bool poll(Lab& lab);
  /// Where it drives to: above the dew point in any case.
  [[nodiscard]] double target_c(const Lab& lab) const;
  /// Why a chamber that answers is not on its way; empty where it is.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool drive(Lab& lab);
  void take_refusal(Lab& lab, const std::string& why);
  [[nodiscard]] bool is_on_its_way(const Lab& lab);
  [[nodiscard]] bool is_warm_without(const Lab& lab);
  [[nodiscard]] bool switch_off(Lab& lab);
  [[nodiscard]] bool is_dry(const Lab& lab) const;

  double temp_c_;
  bool driving_ = false;
  int told_ = 0;  ///< times that a chamber which answers was told where to go
  std::string trouble_;
  bool is_off_ = false;  ///< for want of a set point
  Clock::time_point next_try_{};
  Clock::time_point next_stop_{};
  std::optional<double> warm_since_s_;
};

}  // namespace soak::station
