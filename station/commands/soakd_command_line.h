// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::station::cli {

/// The program `soakd`: parses the command line, runs the daemon, prints errors; returns the exit status.
int run_soakd(int argc, char** argv);

}  // namespace soak::station::cli
