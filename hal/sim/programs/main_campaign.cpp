// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <string>
#include <vector>

#include "hal/sim/programs/programs.h"

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const soak::hal::sim::ProgramOutcome outcome = soak::hal::sim::run_campaign_program(arguments);
  std::cout << outcome.output;
  std::cerr << outcome.errors;
  return outcome.exit_status;
}
