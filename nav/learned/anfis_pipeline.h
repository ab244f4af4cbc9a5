// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nav/learned/error_model.h"
#include "nav/outages/pipeline.h"

/// A filter that a Takagi-Sugeno system helps where there are no fixes [AH05 chapter 7].
namespace soak::nav {

/// When the system learns, and when it is believed.
enum class Learning : std::uint8_t {
  on_line,   ///< artificial outages of the drive before the outage move the consequents, and say whether to believe
  off_line,  ///< it stays as it was learnt, and is always believed
};

/// Corrections of the position [AH05 §7.1]: the filter goes through the outage alone, and what the system expects its
/// error to be is taken off its positions. Velocities are the filter's. Consequents learn from successive outages of 30
/// s, slowly: see FollowingErrorModel. Fails as align() and learn_errors() do.
[[nodiscard]] Pipeline anfis_position(FilterPipeline filter, ErrorModel model, Learning learning = Learning::on_line);

/// Simulated updates, the idea of [AH05 §7.2]: where the filter without fixes is, less its expected error, is given to
/// the filter as a fix, position and velocity, each second. The fix is as good as what was foretold before the outage:
/// ErrorGrowth. The thesis learns what the filter is wrong by from one fix to the next; here it is the error since the
/// last fix, as for anfis_position(). Axes that are not believed stay as the filter alone has them. Fails as
/// anfis_position() does.
[[nodiscard]] Pipeline anfis_updates(FilterPipeline filter, ErrorModel model, Learning learning = Learning::on_line);

}  // namespace soak::nav
