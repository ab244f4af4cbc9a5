// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "db/catalog.h"
#include "station/lab/event_log.h"

namespace soak::station {

/// Seals the run files that a killed soakd left open and enters them into the catalog, voided: nothing that was
/// recorded is lost, and no fit takes half a run unasked. A file that cannot be read is logged and left as it is.
[[nodiscard]] base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log);

}  // namespace soak::station
