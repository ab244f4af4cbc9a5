// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/effects/detail/g_sensitivity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using Matrix = std::array<calib::Vector3, 3>;

class GSensitivity final : public Effect {
 public:
  explicit GSensitivity(const Matrix& matrix) : matrix_(matrix) {}

  void advance_to(const Conditions& now) override { up_ = now.up; }

  [[nodiscard]] double response(calib::Sensor sensor) const override {
    if (!calib::is_gyro(sensor)) return 0.0;
    const calib::Vector3& row = matrix_[calib::axis_of(sensor)];
    return row[0] * up_[0] + row[1] * up_[1] + row[2] * up_[2];
  }

 private:
  Matrix matrix_;
  calib::Vector3 up_{};
};

}  // namespace

std::unique_ptr<Effect> make_g_sensitivity(const EffectOrder& order, ShapeDraws& shape) {
  const bool all_axes = shape.toss("all_axes");
  Matrix matrix{};
  double largest = 0.0;
  for (std::size_t gyro = 0; gyro < 3; ++gyro) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double element = drawn_sign(shape.random()) * shape.random().uniform(0.4, 1.0);
      if (order.gain[gyro] == 0.0 || (!all_axes && axis != gyro)) continue;
      matrix[gyro][axis] = element;
      largest = std::max(largest, std::abs(element));
    }
  }
  for (std::size_t gyro = 0; gyro < 3; ++gyro) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (largest > 0.0) matrix[gyro][axis] /= largest;
      shape.kept(std::string("m_") + "xyz"[gyro] + "xyz"[axis], matrix[gyro][axis]);
    }
  }
  return std::make_unique<GSensitivity>(matrix);
}

}  // namespace soak::hal::sim
