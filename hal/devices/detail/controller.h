// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/devices/chamber.h"
#include "hal/devices/detail/codec.h"
#include "hal/devices/unit_power.h"

namespace soak::hal {

/// Values by the names of their quantities.
using Values = std::map<std::string, double, std::less<>>;

/// A controller that a map describes: quantities, actions and alarms by name, whatever it speaks. Each call opens the
/// link if it is closed and then proves the map's probes before it trusts a value. Names must be in the map. Errors are
/// of kind `device` and name the quantity, where the controller keeps it, and map and address as their place.
class Controller {
 public:
  /// Limits of what may be written.
  struct Range {
    std::optional<double> min;
    std::optional<double> max;
  };

  /// What is done about a value that the controller says it holds already.
  enum class Held : std::uint8_t {
    by_policy,     ///< what the map's policy says
    write_anyway,  ///< written whatever the policy says; a refusal then is no failure, the controller holds it
  };

  explicit Controller(DeviceMap map);
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  [[nodiscard]] bool has(std::string_view quantity) const;
  [[nodiscard]] bool has_action(std::string_view action) const;
  [[nodiscard]] Range range(const std::string& quantity) const;
  /// The number that stands for a code of the quantity; nothing where it has none of that name.
  [[nodiscard]] std::optional<double> code(const std::string& quantity, const std::string& name) const;
  /// Where the controller keeps the quantity, for messages: "register 2820".
  [[nodiscard]] std::string place(const std::string& quantity) const;
  /// Map and address.
  [[nodiscard]] std::string description() const;
  /// Whether the link survived the last call.
  [[nodiscard]] bool answers() const { return codec_->link().is_open(); }

  [[nodiscard]] base::Status connect();
  [[nodiscard]] base::Result<Values> read_all(const std::vector<std::string>& names);
  [[nodiscard]] base::Result<std::vector<ChamberAlarm>> active_alarms();
  /// Writes by the map's policy. The controller is asked for what it holds before and after: what was sent earlier
  /// proves nothing. Refuses (bad_input) a value beyond the map's limits.
  [[nodiscard]] base::Status write(const std::string& name, double value, Held held = Held::by_policy);
  /// Writes the steps of an action of the map, one after the other.
  [[nodiscard]] base::Status run(const std::string& action, Held held = Held::by_policy);
  /// Waits a few tenths of a second for a quantity to become `value`.
  [[nodiscard]] base::Status expect(const std::string& name, double value);

  /// An error of this controller.
  [[nodiscard]] tl::unexpected<base::Error> fail(std::string message) const;

 private:
  [[nodiscard]] tl::unexpected<base::Error> fail(const NoAnswer& fault) const;
  [[nodiscard]] base::Status prove(const Probe& probe);
  [[nodiscard]] base::Status check_limits(const std::string& name, double value) const;
  [[nodiscard]] base::Result<Content> held_content(const std::string& name);
  [[nodiscard]] base::Result<Content> encode(const std::string& name, double value, const Content& held) const;
  [[nodiscard]] base::Status expect_content(const std::string& name, const Content& wanted);

  DeviceMap map_;
  std::unique_ptr<Codec> codec_;
};

/// Unit power over the quantities of a controller, which others may work with too (a chamber's). `request`: kOutput or
/// kChamberOutput.
[[nodiscard]] std::unique_ptr<UnitPower> make_mapped_power(std::shared_ptr<Controller> controller, std::string request);

}  // namespace soak::hal
