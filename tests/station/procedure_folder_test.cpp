// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure_folder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/db/support.h"

namespace soak::station {
namespace {

// With an own folder of unit types, New campaign had lost all procedures.
TEST(ProcedureFolder, AnOwnFolderOfUnitTypesLeavesTheShippedProceduresOnOffer) {
  const db::testing::TempFolder types;
  ::setenv("SOAK_UNIT_TYPES", types.path().c_str(), 1);
  const nlohmann::json offered = procedures_document(procedure_folders(types.path() / "data"), "", 23.0);
  ::unsetenv("SOAK_UNIT_TYPES");
  EXPECT_GT(offered["procedures"].size(), 3U);
}

}  // namespace
}  // namespace soak::station
