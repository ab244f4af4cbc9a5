// SPDX-License-Identifier: Apache-2.0
#include "station/io/host.h"

#include <malloc.h>
#include <pwd.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

#include "base/text.h"

namespace soak::station {
namespace {

std::uint64_t random_word(std::random_device& source) { return (std::uint64_t{source()} << 32) | source(); }

/// Whether standard error goes to systemd's journal, which notes the time of each line itself.
bool stderr_is_the_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat there{};
  return stream != nullptr && ::fstat(STDERR_FILENO, &there) == 0 &&
         stream == std::to_string(there.st_dev) + ":" + std::to_string(there.st_ino);
}

}  // namespace

double now_utc_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string new_run_id() {
  std::random_device source;
  const std::uint64_t first = random_word(source);
  return base::uuid_v7(static_cast<std::uint64_t>(now_utc_s() * 1000.0), first, random_word(source));
}

std::string user_name(const std::string& stated) {
  if (!stated.empty()) return stated;
  if (const char* user = std::getenv("USER"); user != nullptr && *user != '\0') return user;
  const struct passwd* account = ::getpwuid(::geteuid());
  return account != nullptr ? account->pw_name : "unknown";
}

std::string software_version() { return SOAK_VERSION; }

/// By default glibc gives threads eight heaps for each processor, and each of them keeps what it once needed. A run is
/// sealed by a thread of its own, in another heap each time: together they would come to hold, empty, a multiple of
/// what is in use (docs/proofs.md, endurance). soakd's threads allocate too little at a time to wait for one another.
void share_one_heap() { ::mallopt(M_ARENA_MAX, 1); }

std::size_t heap_in_use_bytes() {
  const struct mallinfo2 heap = ::mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

void log_line(const std::string& text) {
  static const auto logger = [] {
    auto made = spdlog::stderr_logger_mt("soakd");
    made->set_pattern(stderr_is_the_journal() ? "%v" : "%Y-%m-%dT%H:%M:%S.%e%z %v");
    made->flush_on(spdlog::level::info);
    return made;
  }();
  logger->info("{}", text);
}

}  // namespace soak::station
