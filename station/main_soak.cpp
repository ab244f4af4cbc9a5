// SPDX-License-Identifier: Apache-2.0
#include "station/commands/command.h"

int main(int argc, char** argv) {
  using namespace soak::station;
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
