// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/lab/event_log.h"

namespace soak::station {

/// Seals the run files that a killed soakd left open and enters them into the catalog, voided, with every row that was
/// flushed: nothing that was recorded is lost, and no fit takes half a run unasked. So is done with files that were
/// sealed but not entered. A file that cannot be read is logged and left as it is; one without samples is sealed, and
/// stays outside the catalog.
[[nodiscard]] base::Status enter_lost_runs(db::Catalog& catalog, EventLog& log);

}  // namespace soak::station
