// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "station/lab/step_task.h"

namespace soak::station {
namespace {

/// Judges what the pre-flight recorded: whatever would spoil the campaign ends it now.
class Check : public StepTask {
 public:
  StepProgress poll(Lab& lab) override {
    const std::vector<std::string> findings = preflight_findings(lab.preflight);
    lab.preflight.clear();
    if (findings.empty()) return StepProgress::done("nothing found");
    for (const std::string& finding : findings) lab.log.add("pre-flight", "", finding);
    return StepProgress::failed(
        {base::ErrorKind::limits, fmt::format("pre-flight: {}", fmt::join(findings, "; ")), "pre-flight"});
  }
};

/// Ends the run: its file is sealed and entered into the catalog, then the units are off for a while.
class PowerOff : public StepTask {
 public:
  explicit PowerOff(const Step& step) : seconds_(step.seconds) {}

  StepProgress poll(Lab& lab) override {
    if (!sealed_) {
      if (const auto ended = lab.end_run(std::nullopt); !ended) return StepProgress::failed(ended.error());
      sealed_ = true;
    }
    if (!off_at_s_) {
      const auto off = lab.supply ? insistence_.attempt([&] { return switch_off(lab); }) : base::Result<bool>(true);
      if (!off) return StepProgress::failed(off.error());
      if (*off) off_at_s_ = lab.now_s();
      return StepProgress::running();
    }
    return lab.now_s() - *off_at_s_ >= seconds_ ? StepProgress::done() : StepProgress::running();
  }

 private:
  static base::Status switch_off(Lab& lab) {
    for (const auto& unit : lab.units) {
      if (!unit->slot().power_output) continue;
      if (auto status = lab.supply->switch_off(*unit->slot().power_output, lab.now_s()); !status) return status;
    }
    return {};
  }

  double seconds_;
  bool sealed_ = false;
  std::optional<double> off_at_s_;
  Insistence insistence_;
};

}  // namespace

std::unique_ptr<StepTask> make_check() { return std::make_unique<Check>(); }

std::unique_ptr<StepTask> make_power_off(const Step& step) { return std::make_unique<PowerOff>(step); }

}  // namespace soak::station
