// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anfis/model/membership.h"
#include "base/result.h"

namespace soak::anfis {

/// How the degrees of a rule's premises combine to its firing strength [AH05 eq. 5.8].
enum class TNorm { product, minimum };

/// "product", "minimum".
[[nodiscard]] std::string_view name(TNorm t_norm);

/// Scaled value u = (x - centre) / half_range: training data span [-1, 1].
struct Scale {
  double centre = 0.0;
  double half_range = 1.0;  ///< > 0

  [[nodiscard]] double scaled(double x) const { return (x - centre) / half_range; }
  [[nodiscard]] double unscaled(double u) const { return centre + half_range * u; }

  friend bool operator==(const Scale&, const Scale&) = default;
};

/// One input of a model.
struct Input {
  std::string name;  ///< for people; may be empty
  Scale scale;
  double min = 0.0;  ///< range of the training data: the model says nothing outside it
  double max = 0.0;
  std::vector<Membership> memberships;  ///< in scaled units

  friend bool operator==(const Input&, const Input&) = default;
};

/// In Rule::premise: the rule does not ask about this input.
inline constexpr int kAny = -1;

/// One Takagi-Sugeno rule "if u_1 is A and u_2 is B.. then f = gains . u + offset", in scaled units.
struct Rule {
  std::vector<int> premise;   ///< per input: index into its memberships, or kAny
  std::vector<double> gains;  ///< consequent: one per input, all 0 in a model of order 0
  double offset = 0.0;        ///< consequent
  std::vector<int> dropped;   ///< inputs whose gain is 0 by structure (Fuzzy-OLS): learning leaves it so; rising

  friend bool operator==(const Rule&, const Rule&) = default;
};

/// Takagi-Sugeno system with any number of inputs and one output [AH05 eq. 5.5-5.11]. With u the scaled inputs,
///     w_i = T over premises of mu(u_j),   wbar_i = w_i / sum w,
///     y = output.centre + output.half_range * sum_i wbar_i (gains_i . u + offset_i).
/// Memberships may be shared by rules (grid) or belong to one rule each (scatter): Rule::premise says.
struct Model {
  int order = 1;  ///< 1: linear consequents, 0: constant ones
  TNorm t_norm = TNorm::product;
  std::vector<Input> inputs;
  Scale output;
  std::vector<Rule> rules;

  friend bool operator==(const Model&, const Model&) = default;
};

/// Most inputs, memberships of one input and rules that a model may have.
inline constexpr std::size_t kMostInputs = 64;
inline constexpr std::size_t kMostMemberships = 256;
inline constexpr std::size_t kMostRules = 4096;

/// Whether the model can be evaluated: inputs and rules within the limits above, every number finite and at most 1e100,
/// every membership valid, half ranges positive, min <= max, every rule with one premise and one gain per input, at
/// least one premise that is not kAny unless it is the only rule, gains 0 in order 0 and where dropped. The message
/// names the field.
[[nodiscard]] base::Status validate(const Model& model);

/// What a model says at one point.
struct Inference {
  double value = 0.0;     ///< in the units of the training output; finite for every finite x of a valid model
  bool in_range = false;  ///< every input inside the range of the training data: else the model extrapolates
  bool fired = false;  ///< some rule fires. Where none does (every strength is zero or underflows) the strengths keep
                       ///< their ratios in the limit, so that the nearest rules remain; see log_degree()
};

/// Output at x, one value per input, in the units of the training data. Nothing is clamped.
[[nodiscard]] Inference infer(const Model& model, std::span<const double> x);

/// The value alone, for callers that have judged the range themselves.
[[nodiscard]] double evaluate(const Model& model, std::span<const double> x);
/// The same for a model with one input.
[[nodiscard]] double evaluate(const Model& model, double x);

/// Values of many points: x holds the inputs of one point after the other, y one value per point.
void evaluate(const Model& model, std::span<const double> x, std::span<double> y);

/// Normalised firing strengths at x, one per rule: not negative, their sum is 1 [AH05 eq. 5.9].
void firing_strengths(const Model& model, std::span<const double> x, std::span<double> strengths);

/// Number of free consequent parameters: offsets, and in order 1 gains that are not dropped.
[[nodiscard]] std::size_t consequent_count(const Model& model);

/// Number of premise parameters: those of all memberships of all inputs.
[[nodiscard]] std::size_t premise_count(const Model& model);

}  // namespace soak::anfis
