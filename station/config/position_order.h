// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "station/config/procedure.h"

namespace soak::station {

/// The order of the positions in run number `run` (from 0). What turns and reverses are the axes, so that + and − of
/// one stay side by side. `rotate`: each run begins one axis later. `reverse`: every other run goes backwards.
/// `rotate_and_reverse`: both, backwards in every other run and one axis later after each pair: with three axes, six
/// runs have six orders.
[[nodiscard]] std::vector<std::string> positions_of_run(const Procedure& procedure, int run);

}  // namespace soak::station
