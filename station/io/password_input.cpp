// SPDX-License-Identifier: Apache-2.0
#include "station/io/password_input.h"

#include <termios.h>
#include <unistd.h>

#include <iostream>

namespace soak::station {
namespace {

/// For as long as it lives the terminal does not show what is typed. Ctrl-C meanwhile only sets a flag
/// (catch_signals()), so that the terminal is always given back as it was.
class NoEcho {
 public:
  NoEcho() {
    changed_ = ::tcgetattr(STDIN_FILENO, &before_) == 0;
    if (!changed_) return;
    termios silent = before_;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    silent.c_lflag |= ECHONL;
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent);
  }
  NoEcho(const NoEcho&) = delete;
  NoEcho& operator=(const NoEcho&) = delete;
  ~NoEcho() {
    if (changed_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
  }

 private:
  termios before_{};
  bool changed_ = false;
};

base::Result<std::string> read_line() {
  std::string line;
  if (!std::getline(std::cin, line)) return base::bad_input("no password came", "standard input");
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

}  // namespace

base::Result<std::string> read_password(const std::string& prompt) {
  if (::isatty(STDIN_FILENO) == 0) return read_line();
  const NoEcho silent;
  std::cerr << prompt << ": " << std::flush;
  auto first = read_line();
  if (!first) return first;
  std::cerr << "again: " << std::flush;
  auto second = read_line();
  if (!second) return second;
  if (*first != *second) return base::bad_input("the two differ: nothing was changed", "password");
  return first;
}

}  // namespace soak::station
