// SPDX-License-Identifier: Apache-2.0
#include "station/lab/doctor.h"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "hal/usb/usb_devices.h"
#include "station/lab/run_recorder.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;

constexpr double kLittleSpace_bytes = 5e9;

DoctorCheck good(std::string subject, std::string text) {
  return {std::move(subject), CheckOutcome::ok, std::move(text)};
}

DoctorCheck failed(std::string subject, std::string text, base::ErrorKind kind = base::ErrorKind::device) {
  return {std::move(subject), CheckOutcome::failed, std::move(text), kind};
}

std::string account_name() {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(::geteuid(), &entry, buffer.data(), buffer.size(), &found) != 0 || found == nullptr) {
    return fmt::format("{}", ::geteuid());
  }
  return entry.pw_name;
}

std::string group_name(gid_t id) {
  std::array<char, 4096> buffer{};
  group entry{};
  group* found = nullptr;
  if (::getgrgid_r(id, &entry, buffer.data(), buffer.size(), &found) != 0 || found == nullptr) {
    return fmt::format("{}", id);
  }
  return entry.gr_name;
}

bool may_use(const std::string& node) { return ::access(node.c_str(), R_OK | W_OK) == 0; }

DoctorCheck check_serial(const std::string& subject, const std::string& device) {
  struct stat node{};
  if (::stat(device.c_str(), &node) != 0) {
    return failed(subject, fmt::format("{} does not exist ({}): is the device plugged in, and is this its name?",
                                       device, std::generic_category().message(errno)));
  }
  if (!S_ISCHR(node.st_mode)) return failed(subject, fmt::format("{} is not a serial port", device));
  if (may_use(device)) return good(subject, fmt::format("{} is present", device));
  if ((node.st_mode & (S_IRGRP | S_IWGRP)) != (S_IRGRP | S_IWGRP)) {
    return failed(subject,
                  fmt::format("no permission for {}, nor has its group: see docs/hardware.md, udev rules", device));
  }
  const std::string group = group_name(node.st_gid);
  return failed(
      subject,
      fmt::format("no permission for {}: {} is not in its group '{}'. 'sudo usermod -aG {} {}', then log in again",
                  device, account_name(), group, group, account_name()));
}

DoctorCheck check_usb(const std::string& subject, const hal::UsbAddress& address) {
  const auto device = hal::find_usb_device(address);
  if (!device) return failed(subject, device.error().where + ": " + device.error().message);
  const std::string what =
      fmt::format("{} at {}{}{}", hal::text_of(address), device->path, device->name.empty() ? "" : ", " + device->name,
                  device->serial.empty() ? "" : ", serial " + device->serial);
  if (may_use(device->node)) return good(subject, what);
  return failed(subject, fmt::format("{}: no permission for {}: install the udev rules (docs/hardware.md), put {} into "
                                     "the group 'plugdev', then plug it in again",
                                     what, device->node, account_name()));
}

DoctorCheck check_hubs(const hal::UsbHubs& hubs, const std::vector<Slot>& slots) {
  std::string outputs;
  for (const Slot& slot : slots) {
    if (!slot.power_output) continue;
    const auto able = hal::may_switch(hubs, *slot.power_output);
    if (!able) return failed("power", able.error().where + ": " + able.error().message);
    outputs += fmt::format("{}{}", outputs.empty() ? "" : ", ", *slot.power_output);
  }
  return good("power", fmt::format("USB hub {}: may switch outputs {}", fmt::join(hubs.paths, ", "), outputs));
}

struct CheckAddress {
  std::string subject;

  DoctorCheck operator()(const hal::TcpAddress& tcp) const {
    return good(subject, fmt::format("tcp {}:{} is configured; not asked whether it answers", tcp.host, tcp.port));
  }
  DoctorCheck operator()(const hal::SerialAddress& serial) const { return check_serial(subject, serial.device); }
  DoctorCheck operator()(const hal::UsbAddress& usb) const { return check_usb(subject, usb); }
  DoctorCheck operator()(const hal::RecordedAddress& recorded) const { return good(subject, hal::text_of(recorded)); }
};

/// When the newest run of the catalog was made.
std::optional<double> newest_run_utc_s(const db::Catalog& catalog) {
  const auto runs = catalog.runs({});
  if (!runs || runs->empty()) return std::nullopt;
  return std::max_element(runs->begin(), runs->end(),
                          [](const auto& a, const auto& b) { return a.created_utc_s < b.created_utc_s; })
      ->created_utc_s;
}

}  // namespace

std::vector<DoctorCheck> check_devices(const StationConfig& config) {
  std::vector<DoctorCheck> checks;
  const auto check_controller = [&](const char* subject, const hal::DeviceMap& map) {
    checks.push_back(std::visit(CheckAddress{subject}, map.link.address));
  };
  check_controller("chamber", config.chamber);
  if (config.fixture) check_controller("fixture", *config.fixture);
  if (const auto* power = std::get_if<hal::DeviceMap>(&config.power)) {
    check_controller("power", *power);
  }
  if (const auto* hubs = std::get_if<hal::UsbHubs>(&config.power)) checks.push_back(check_hubs(*hubs, config.slots));
  for (const Slot& slot : config.slots) checks.push_back(std::visit(CheckAddress{"slot " + slot.name}, slot.address));
  return checks;
}

DoctorCheck check_disk_space(const fs::path& folder) {
  constexpr const char* kSubject = "disk";
  std::error_code failure;
  // Of a folder that is not there yet the one that it will be made in.
  fs::path there = fs::absolute(folder, failure);
  while (!there.empty() && !fs::exists(there, failure) && there != there.root_path()) there = there.parent_path();
  const auto space = fs::space(there, failure);
  if (failure)
    return failed(kSubject, fmt::format("{}: {}", there.string(), failure.message()), base::ErrorKind::internal);
  if (::access(there.c_str(), W_OK | X_OK) != 0) {
    return failed(kSubject, fmt::format("{} cannot write to {}", account_name(), there.string()),
                  base::ErrorKind::bad_input);
  }
  const auto left = static_cast<double>(space.available);
  const std::string text = fmt::format("{:.1f} GB left in {}", 1e-9 * left, there.string());
  if (left < kLittleSpace_bytes) {
    const double day_bytes = estimated_bytes(100.0, 1, 86400.0);
    return {kSubject,
            CheckOutcome::warning,
            fmt::format("{}: a unit at 100 Hz writes {:.1f} GB a day", text, 1e-9 * day_bytes),
            {}};
  }
  return good(kSubject, text);
}

DoctorCheck missing_catalog(const fs::path& folder, bool is_new) {
  constexpr const char* kSubject = "database";
  const std::string text = fmt::format("there is no catalog (station.db) in {}", folder.string());
  if (!is_new) {
    return failed(kSubject, text + ": it is no data folder of Soak, or its disk is not mounted",
                  base::ErrorKind::bad_input);
  }
  return {
      kSubject,
      CheckOutcome::warning,
      text + ": soakd makes it when it is started for the first time; if there was one, look that its disk is mounted",
      {}};
}

DoctorCheck check_database(const base::Result<db::Catalog>& catalog) {
  constexpr const char* kSubject = "database";
  const auto told = [&](const base::Error& error) {
    return failed(kSubject, error.where.empty() ? error.message : error.where + ": " + error.message, error.kind);
  };
  if (!catalog) return told(catalog.error());
  if (const auto whole = catalog->verify(); !whole) return told(whole.error());
  return good(kSubject, "intact ('soak runs verify' also checks the run files)");
}

DoctorCheck check_clock(const db::Catalog* catalog, double now_utc_s) {
  constexpr const char* kSubject = "clock";
  if (const auto newest_s = catalog != nullptr ? newest_run_utc_s(*catalog) : std::nullopt;
      newest_s && *newest_s > now_utc_s) {
    return failed(kSubject,
                  "it is earlier than the newest run in the catalog: set the clock before anything is recorded",
                  base::ErrorKind::bad_input);
  }
  timex state{};
  const bool kept = ::adjtimex(&state) != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
  if (!kept)
    return {kSubject, CheckOutcome::warning, "not synchronised by a time service: the dates of runs may be wrong", {}};
  return good(kSubject, "synchronised by a time service");
}

}  // namespace soak::station
