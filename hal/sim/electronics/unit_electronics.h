// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "base/bytes.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/inertial_unit.h"
#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {

/// What a unit speaks.
enum class UnitKind : std::uint8_t { xsens, ahrs400, vectornav };

/// The electronics of a unit as its host sees it: power, and what goes over its line.
class UnitElectronics {
 public:
  static constexpr Tick kNever = std::numeric_limits<Tick>::max();

  UnitElectronics(const CampaignConfig& config, int number)
      : magnitudes_(config.lab.electronics), unit_(config, number) {}
  UnitElectronics(const UnitElectronics&) = delete;
  UnitElectronics& operator=(const UnitElectronics&) = delete;
  virtual ~UnitElectronics() = default;

  virtual void switch_power(bool on, Tick now) = 0;
  /// Bytes from the host.
  virtual void receive(std::span<const std::uint8_t> bytes, Tick now) = 0;
  /// Does what is due at `now`.
  virtual void advance_to(Tick now, const Attitude& fixture) = 0;
  /// Next tick at which something is due.
  [[nodiscard]] Tick next_due() const { return next_due_; }
  /// Measures and sends packets without being asked.
  [[nodiscard]] virtual bool streams() const = 0;

  [[nodiscard]] InertialUnit& unit() { return unit_; }
  /// Bytes for the host since the last call.
  [[nodiscard]] base::Bytes take_output() { return std::exchange(output_, {}); }
  [[nodiscard]] std::size_t output_size() const { return output_.size(); }

 protected:
  /// Starts the unit's own time and its boot, which ends at next_due(); or stops the unit: nothing is due then.
  void set_power(bool on, Tick now) {
    next_due_ = on ? now + ticks_of(magnitudes_.boot_s) : kNever;
    if (!on) return unit_.stop();
    start_ = now;
    unit_.start();
  }
  void put_out(std::span<const std::uint8_t> bytes) { output_.insert(output_.end(), bytes.begin(), bytes.end()); }

  ElectronicsMagnitudes magnitudes_;
  InertialUnit unit_;
  Tick start_ = 0;  ///< of the unit's own time
  Tick next_due_ = kNever;

 private:
  base::Bytes output_;
};

// The `number`-th unit, from 1, of the laboratory, by family.
[[nodiscard]] std::unique_ptr<UnitElectronics> make_xbus_device(const CampaignConfig& config, int number);
[[nodiscard]] std::unique_ptr<UnitElectronics> make_ahrs400_device(const CampaignConfig& config, int number);
[[nodiscard]] std::unique_ptr<UnitElectronics> make_vectornav_device(const CampaignConfig& config, int number);

[[nodiscard]] inline std::unique_ptr<UnitElectronics> make_unit(UnitKind kind, const CampaignConfig& config,
                                                                int number) {
  if (kind == UnitKind::ahrs400) return make_ahrs400_device(config, number);
  return kind == UnitKind::vectornav ? make_vectornav_device(config, number) : make_xbus_device(config, number);
}

}  // namespace soak::hal::sim
