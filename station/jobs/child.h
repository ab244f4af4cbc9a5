// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// A program with the words of its command line, as they are: no shell reads them.
struct ChildProgram {
  std::filesystem::path program;
  std::vector<std::string> arguments;  ///< after the program's name
  std::string user;                    ///< who it works for: its $USER
};

/// How a program ended and what it said.
struct ChildEnd {
  int exit_status = 0;   ///< 128 and the signal's number where a signal ended it
  std::string output;    ///< standard output, kMostOutput bytes at most
  std::string errors;    ///< standard error, kMostErrors bytes at most
  bool is_whole = true;  ///< whether nothing of them was left out
  bool stopped = false;  ///< because it was asked to
};

inline constexpr std::size_t kMostOutput = std::size_t{32} << 20;
inline constexpr std::size_t kMostErrors = std::size_t{64} << 10;

/// Runs a program to its end. It disturbs nobody: lowest but for what idles (nice 10), the first to go where memory is
/// short, none of this process's open files and sockets with it. Asked to end (SIGTERM) once `stop` is set, so that
/// what it has just committed it also reports; killed three seconds later, as what it writes survives that (the catalog
/// by its transactions), and where the calling thread ends, however that happens. Fails (internal) where it cannot be
/// started. `hear`: gets what it has said on standard error by now, whenever there is more of it; a `soak` then says
/// there how far it is ($SOAK_PROGRESS).
[[nodiscard]] base::Result<ChildEnd> run_child(const ChildProgram& child, const std::atomic<bool>& stop,
                                               const std::function<void(std::string_view errors)>& hear = {});

}  // namespace soak::station
