// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "hal/devices/detail/block_plan.h"
#include "hal/devices/detail/quantity_access.h"
#include "hal/devices/detail/registers.h"
#include "hal/links/detail/modbus_link.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// A controller that a register map describes: quantities, actions and alarms by name. Each call opens the link if it
/// is closed and then proves the map's probes before it trusts a value. Names must be in the map. Errors are of kind
/// `device` and name the quantity, its register, and map and address as their place.
class Controller final : public QuantityAccess {
 public:
  explicit Controller(RegisterMap map);

  [[nodiscard]] const RegisterMap& map() const { return map_; }
  [[nodiscard]] bool has(std::string_view quantity) const override;
  [[nodiscard]] bool has_action(std::string_view action) const override;
  [[nodiscard]] Range range(const std::string& quantity) const override;
  [[nodiscard]] bool has_code(const std::string& quantity, const std::string& name) const override;
  [[nodiscard]] double code(const std::string& quantity, const std::string& name) const override;
  [[nodiscard]] std::string place(const std::string& quantity) const override;
  [[nodiscard]] std::string description() const override;

  [[nodiscard]] base::Status connect() override;
  [[nodiscard]] base::Result<Values> read_all(const std::vector<std::string>& names) override;
  [[nodiscard]] base::Result<double> read(const std::string& name);
  [[nodiscard]] base::Result<std::vector<ChamberAlarm>> active_alarms() override;
  /// Writes by the map's policy. The register is asked for what it holds before and after: what was sent earlier proves
  /// nothing. Refuses (bad_input) a value beyond the map's limits.
  [[nodiscard]] base::Status write(const std::string& name, double value) override;
  [[nodiscard]] base::Status run(const std::string& action) override;
  [[nodiscard]] base::Status expect(const std::string& name, double value) override;

  /// An error of this controller.
  [[nodiscard]] tl::unexpected<base::Error> fail(std::string message) const;

 private:
  /// Content of registers by function and address.
  using Image = std::map<std::pair<int, int>, std::uint16_t>;
  struct Content {
    Words words;
    int decimals = 0;
  };

  [[nodiscard]] LinkKind link_kind() const;
  [[nodiscard]] base::Status prove(const Probe& probe);
  [[nodiscard]] base::Result<Image> fetch(const std::vector<RegisterSpan>& spans);
  [[nodiscard]] LinkResult fetch_block(const RegisterBlock& block, Image& image);
  [[nodiscard]] base::Result<Content> content(const std::string& name, const Image& image) const;
  [[nodiscard]] base::Result<Content> fetch_content(const std::string& name);
  [[nodiscard]] base::Result<double> value(const std::string& name, const Image& image) const;
  [[nodiscard]] base::Status send(const std::string& name, const Words& words);
  [[nodiscard]] base::Status expect_words(const std::string& name, const Words& words);
  [[nodiscard]] base::Status check_limits(const std::string& name, double value) const;
  void append_spans(const std::string& name, std::vector<RegisterSpan>& spans) const;

  RegisterMap map_;
  ModbusLink link_;
  bool over_holes_ = true;  ///< the controller has not yet refused a block with registers that it lacks
};

}  // namespace soak::hal
