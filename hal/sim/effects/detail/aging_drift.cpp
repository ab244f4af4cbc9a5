// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/aging_drift.h"

namespace soak::hal::sim {
namespace {

class AgingDrift final : public Effect {
 public:
  void advance_to(const Conditions& now) override {
    if (!started_) first_utc_s_ = now.utc_s;
    started_ = true;
    age_kh_ = (now.utc_s - first_utc_s_) / 3.6e6;
  }

  [[nodiscard]] double response(calib::Sensor) const override { return age_kh_; }

 private:
  bool started_ = false;
  double first_utc_s_ = 0.0;
  double age_kh_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_aging_drift(const EffectOrder&, ShapeDraws&) { return std::make_unique<AgingDrift>(); }

}  // namespace soak::hal::sim
