// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/devices/detail/quantity_access.h"
#include "hal/links/detail/text_link.h"
#include "hal/maps/text_map.h"

namespace soak::hal {

/// A controller that a text map describes. Within one call each command is sent once, however many values its answer
/// carries.
class TextController final : public QuantityAccess {
 public:
  explicit TextController(TextMap map);

  [[nodiscard]] bool has(std::string_view quantity) const override;
  [[nodiscard]] bool has_action(std::string_view action) const override;
  [[nodiscard]] Range range(const std::string& quantity) const override;
  [[nodiscard]] bool has_code(const std::string& quantity, const std::string& name) const override;
  [[nodiscard]] double code(const std::string& quantity, const std::string& name) const override;
  [[nodiscard]] std::string place(const std::string& quantity) const override;
  [[nodiscard]] std::string description() const override;

  [[nodiscard]] base::Status connect() override;
  [[nodiscard]] base::Result<Values> read_all(const std::vector<std::string>& names) override;
  [[nodiscard]] base::Result<std::vector<ChamberAlarm>> active_alarms() override;
  [[nodiscard]] base::Status write(const std::string& name, double value) override;
  [[nodiscard]] base::Status run(const std::string& action) override;
  [[nodiscard]] base::Status expect(const std::string& name, double value) override;

 private:
  /// Answers by their commands.
  using Answers = std::map<std::string, std::string>;

  /// The answer, asked for unless `answers` has it. `what`: for messages.
  [[nodiscard]] base::Result<std::string> ask(const std::string& what, const std::string& command, Answers& answers);
  [[nodiscard]] base::Status prove(const TextProbe& probe);
  [[nodiscard]] base::Result<double> fetch(const std::string& name, Answers& answers);
  /// Sends a command that writes; the controller must accept it.
  [[nodiscard]] base::Status carry_out(const std::string& what, const std::string& command);
  /// expect() within a call that has begun.
  [[nodiscard]] base::Status read_back(const std::string& name, double value);
  /// Asks the controller what it says of a command that it did not answer.
  [[nodiscard]] base::Status confirm(const std::string& what, const std::string& command);
  /// An error of an answer, as one of this controller.
  [[nodiscard]] tl::unexpected<base::Error> fault(const std::string& what, const base::Error& error) const;

  TextMap map_;
  TextLink link_;
};

}  // namespace soak::hal
