// SPDX-License-Identifier: Apache-2.0
#include "station/commands/command_line.h"

int main(int argc, char** argv) { return soak::station::cli::run(argc, argv); }
