// SPDX-License-Identifier: Apache-2.0
#include <malloc.h>

#include "station/commands/command.h"

namespace {

/// A search takes and frees matrices of some 100 kB by the thousand: each handed back to the system would be zeroed
/// there and paged in anew, a tenth of the time. What is free is kept until the command ends, which is soon.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace soak::station;
  keep_freed_memory();
  const Program soak{
      "soak",
      "Soak: thermal calibration of MEMS inertial units",
      "'soak COMMAND --help' explains a command and shows an example.\n"
      "Exit status: 0 done, 1 failed, 2 wrong usage or bad input, 3 a device failed, 4 stored data are damaged, 5 a "
      "unit exceeds its limits.",
      {import_commands(),    run_show_commands(),      run_commands(),       run_drop_commands(), fit_commands(),
       export_commands(),    eval_commands(),          correct_commands(),   verify_commands(),   unit_commands(),
       campaign_commands(),  procedure_commands(),     type_commands(),      signal_commands(),   key_commands(),
       check_commands(),     report_commands(),        reference_commands(), gap_commands(),      chamber_commands(),
       make_safe_commands(), doctor_commands(),        event_commands(),     backup_commands(),   user_commands(),
       alarm_commands(),     nav_commands(),           release_commands(),   model_commands(),    merge_commands(),
       archive_commands(),   model_compare_commands(), plan_commands()}};
  return run_program(soak, argc, argv);
}
