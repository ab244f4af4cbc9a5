// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/cross_axis.h"

#include <array>
#include <string>

#include "base/units.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using Matrix = std::array<calib::Vector3, 3>;

class CrossAxis final : public Effect {
 public:
  explicit CrossAxis(const Matrix& matrix) : matrix_(matrix) {}

  void advance_to(const Conditions& now) override {
    warmth_k_ = now.element_c - 25.0;
    up_ = now.up;
  }

  [[nodiscard]] double response(calib::Sensor sensor) const override {
    if (calib::is_gyro(sensor)) return 0.0;
    const calib::Vector3& row = matrix_[calib::axis_of(sensor)];
    return base::kStandardGravity_mps2 * warmth_k_ * (row[0] * up_[0] + row[1] * up_[1] + row[2] * up_[2]);
  }

 private:
  Matrix matrix_;
  double warmth_k_ = 0.0;
  calib::Vector3 up_{};
};

}  // namespace

std::unique_ptr<Effect> make_cross_axis(const EffectOrder&, ShapeDraws& shape) {
  Matrix matrix{};
  for (std::size_t sensor = 0; sensor < 3; ++sensor) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == sensor) continue;
      const double element = drawn_sign(shape.random()) * shape.random().uniform(0.5, 1.0);
      matrix[sensor][axis] = shape.kept(std::string("c_") + "xyz"[sensor] + "xyz"[axis], element);
    }
  }
  return std::make_unique<CrossAxis>(matrix);
}

}  // namespace soak::hal::sim
