// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/curve/calibration.h"
#include "calib/estimate/model_term.h"

namespace soak::calib {

/// A term as it leaves the laboratory: one entry for each of its parts. Of `thermal_hysteresis` the mean that the
/// curves keep (TermPart::centre) goes along as parameters `mean_1_c`, `mean_1`, `mean_2_c` ..., with which a device
/// can follow the term; where float32 cannot tell their temperatures apart or they are too many for the file (124),
/// they stay here, and the term is lab only.
[[nodiscard]] std::vector<AcceptedTerm> deployed_term(const ModelTerm& term);

/// Makes those terms lab only of which a file would carry a part as such: what a model says of them is then what the
/// file does. After their `centre` is known.
void keep_in_the_lab_what_no_file_carries(std::vector<ModelTerm>& terms);

/// Whether a device can follow a term, as the format asks of those that are not lab only: of `thermal_hysteresis` a
/// width above 0, and the mean as the last parameters, in whole pairs whose temperatures rise in float32. True of all
/// others.
[[nodiscard]] bool can_be_followed(const AcceptedTerm& term);

/// Terms of a calibration that a device corrects while its temperature moves (soak_apply_moving, soak_apply_history),
/// with the mean that its curves keep; those that are lab only are not among them.
[[nodiscard]] std::vector<ModelTerm> moving_terms(const Calibration& calibration);

}  // namespace soak::calib
