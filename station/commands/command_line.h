// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::station::cli {

/// The program `soak`: parses the command line, runs the command, prints errors; returns the exit status.
int run(int argc, char** argv);

}  // namespace soak::station::cli
