// SPDX-License-Identifier: Apache-2.0
// 64 Xsens units of 200 Hz on pseudo-terminals, played by a process of its own; this one drives them as soakd does:
// poll(), then every unit. Prints its share of one core, beside that of a loop that only reads the bytes.
// Arguments: units, seconds.
#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "hal/links/detail/byte_source.h"
#include "tests/hal/xsens_peer.h"

namespace soak::hal {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::duration;

constexpr double kRate_hz = 200.0;

struct Line {
  int master = -1;
  int slave = -1;
  std::string name;
};

Line open_line() {
  Line line;
  std::array<char, 64> name{};
  if (::openpty(&line.master, &line.slave, name.data(), nullptr, nullptr) != 0) std::exit(1);
  termios raw{};
  ::cfmakeraw(&raw);
  ::tcsetattr(line.slave, TCSANOW, &raw);
  line.name = name.data();
  return line;
}

double used_s() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Plays the units until it is ended. Units that are not asked anything stream at once if `unasked`.
[[noreturn]] void play(const std::vector<Line>& lines, bool unasked) {
  std::vector<imu::test::ScriptedUnit> units(lines.size());
  for (auto& unit : units) unit.measuring = unasked;
  std::vector<pollfd> waiting;
  for (const Line& line : lines) waiting.push_back({line.master, POLLIN, 0});
  auto next = Clock::now();
  for (;;) {
    next += std::chrono::microseconds(5000);
    std::this_thread::sleep_until(next);
    ::poll(waiting.data(), waiting.size(), 0);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      units[i].ticks_per_packet = 50;
      imu::test::Bytes bytes;
      if ((waiting[i].revents & POLLIN) != 0) {
        std::array<std::uint8_t, 512> buffer;
        const ssize_t got = ::read(lines[i].master, buffer.data(), buffer.size());
        if (got > 0) bytes = units[i].take(std::span(buffer).first(static_cast<std::size_t>(got)));
      }
      if (units[i].measuring) {
        const imu::test::Bytes packet = units[i].packet();
        bytes.insert(bytes.end(), packet.begin(), packet.end());
      }
      (void)!::write(lines[i].master, bytes.data(), bytes.size());
    }
  }
}

/// Runs `turn` for some seconds and returns the share of a core that it took; the first second does not count.
template <class Turn>
double share_of_a_core(double seconds, Turn turn) {
  const auto begin = Clock::now();
  auto since = begin;
  double before_s = 0.0;
  while (duration<double>(Clock::now() - begin).count() < seconds + 1.0) {
    turn();
    if (since == begin && duration<double>(Clock::now() - begin).count() > 1.0) {
      since = Clock::now();
      before_s = used_s();
    }
  }
  return (used_s() - before_s) / duration<double>(Clock::now() - since).count();
}

template <class Things, class Fd>
void wait_for(const Things& things, Fd fd) {
  std::vector<pollfd> fds;
  for (const auto& thing : things) fds.push_back({fd(*thing), POLLIN, 0});
  ::poll(fds.data(), fds.size(), 20);
}

double drive_units(const std::vector<Line>& lines, double seconds) {
  std::vector<std::unique_ptr<Imu>> units;
  for (const Line& line : lines) {
    units.push_back(make_imu({.address = SerialAddress{line.name, 921600}, .decoder = UnitDecoder::xsens}));
    if (!units.back()->open({.rate_hz = kRate_hz})) std::exit(1);
  }
  std::vector<ImuSample> samples;
  std::size_t count = 0;
  const double share = share_of_a_core(seconds, [&] {
    wait_for(units, [](const Imu& unit) { return unit.wait_fd(); });
    for (const auto& unit : units) {
      samples.clear();
      if (!unit->poll(samples)) std::exit(1);
      count += samples.size();
    }
  });
  std::uint64_t lost = 0;
  for (const auto& unit : units) lost += unit->statistics().lost_packets;
  fmt::print("{} units, {} samples, {} lost\n", units.size(), count, lost);
  return share;
}

double read_bytes(const std::vector<Line>& lines, double seconds) {
  std::vector<std::unique_ptr<imu::ByteSource>> sources;
  for (const Line& line : lines) {
    sources.push_back(imu::make_serial_source({line.name, 921600}));
    if (!sources.back()->open()) std::exit(1);
  }
  std::array<std::uint8_t, 16384> buffer;
  return share_of_a_core(seconds, [&] {
    wait_for(sources, [](const imu::ByteSource& source) { return source.fd(); });
    for (const auto& source : sources) (void)source->read(buffer);
  });
}

template <class Drive>
double with_units(int count, bool unasked, Drive drive) {
  std::vector<Line> lines;
  for (int i = 0; i < count; ++i) lines.push_back(open_line());
  const pid_t player = ::fork();
  if (player == 0) play(lines, unasked);
  const double share = drive(lines);
  ::kill(player, SIGKILL);
  ::waitpid(player, nullptr, 0);
  for (const Line& line : lines) {
    ::close(line.master);
    ::close(line.slave);
  }
  return share;
}

}  // namespace
}  // namespace soak::hal

/// Share of one core for 64 units at 200 Hz.
constexpr double kLimit = 0.15;

int main(int argc, char** argv) {
  // Options that are meant for other benchmarks are no numbers.
  const int given = argc > 1 ? std::atoi(argv[1]) : 0;
  const int units = given > 0 ? given : 64;
  const double seconds = argc > 2 ? std::strtod(argv[2], nullptr) : 10.0;
  using namespace soak::hal;
  const double drive = with_units(units, false, [&](const auto& lines) { return drive_units(lines, seconds); });
  const double read = with_units(units, true, [&](const auto& lines) { return read_bytes(lines, seconds); });
  fmt::print(
      "as soakd drives them: {:.1f} % of one core (limit for 64 units: {:g} %); only reading the bytes: {:.1f} %; "
      "ratio {:.2f}\n",
      100 * drive, 100 * kLimit, 100 * read, drive / read);
  return drive <= kLimit * units / 64.0 ? 0 : 1;
}
