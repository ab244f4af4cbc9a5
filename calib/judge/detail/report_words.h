// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/judge/verification.h"

namespace soak::calib {

/// What a report says of a unit in one sentence. `verdict`: "pass", "marginal", "fail", "info" (not judged: no or too
/// few limits), "not_measured" (limits were given, no fresh run tests them).
struct VerdictSentence {
  std::string verdict;
  std::string sentence;
};

/// `fit`: the document of `soak fit --json` of the model. `verification`: against fresh runs, absent without such;
/// `fresh_runs`: their names.
[[nodiscard]] VerdictSentence verdict_sentence(const nlohmann::json& fit, bool limits_given,
                                               const std::optional<Verification>& verification,
                                               const std::vector<std::string>& fresh_runs);

/// What to do about a warning of this code, one sentence in plain words (docs/fit.md has the table); empty for an
/// unknown code.
[[nodiscard]] std::string_view remedy_of(std::string_view code);

/// What a warning of this code asks for, the gravest first: the unit is not handed over before it is settled; something
/// is to be done; nothing. An unknown code asks for something.
enum class Urgency { grave, act, none };
[[nodiscard]] Urgency urgency_of(std::string_view code);
[[nodiscard]] std::string_view name_of(Urgency urgency);

}  // namespace soak::calib
