// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/signalfd.h>

#include <iostream>
#include <string>
#include <vector>

#include "hal/sim/programs/programs.h"

int main(int argc, char** argv) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  const int stop_fd = signalfd(-1, &signals, SFD_CLOEXEC);

  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto announce = [](const std::string& line) { std::cout << line << std::flush; };
  const soak::hal::sim::ProgramOutcome outcome = soak::hal::sim::run_soaksim(arguments, stop_fd, announce);
  std::cout << outcome.output;
  std::cerr << outcome.errors;
  return outcome.exit_status;
}
