// SPDX-License-Identifier: Apache-2.0
#include "station/commands/reference_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/key_file.h"
#include "station/records/reference_register.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using calib::ReferenceKind;

constexpr double kLargestCoverage = 4.0;

/// What a certificate of a kind can say, in the kind's printed unit: beyond that it is a slip of the pen.
struct KindLimits {
  double uncertainty;
  double correction_min;
  double correction_max;
};

KindLimits limits_of(ReferenceKind kind) {
  constexpr std::array<KindLimits, calib::kReferenceKindNames.size()> kLimits = {{
      {10.0, -20.0, 20.0},             // chamber_probe, K
      {5.0, 0.0, 0.0},                 // fixture_squareness, deg: the angles of the faces are not corrected for
      {5.0, -5.0, 5.0},                // level, deg
      {0.1, 9.7, 9.9},                 // gravity, m/s2: from the equator to the poles, up to high mountains
      {5.0, -5.0, 5.0},                // supply, V
      {10'000.0, -100'000., 100'000.}  // rate, ppm
  }};
  return kLimits[static_cast<std::size_t>(kind)];
}

base::Status check_lines(std::initializer_list<std::pair<const std::string&, const char*>> lines) {
  for (const auto& [text, option] : lines) {
    if (auto status = check_carried_line(text, option); !status) return status;
  }
  return {};
}

base::Result<ReferenceKind> kind_of(const std::string& name) {
  const auto kind = calib::reference_kind_named(name);
  if (kind) return *kind;
  return base::bad_input(
      fmt::format("'{}' is no kind of reference; there are {}", name, fmt::join(calib::kReferenceKindNames, ", ")),
      "--kind");
}

base::Result<double> date_of(const std::string& text, const std::string& option) {
  const auto utc_s = parse_iso_date(text);
  if (utc_s) return *utc_s;
  return base::bad_input(fmt::format("'{}' is not a day; write it as 2027-03-01", text), option);
}

base::Status check_correction(const calib::Reference& reference, const std::optional<double>& correction) {
  const KindLimits limits = limits_of(reference.kind);
  const auto unit = calib::printed_unit(reference.kind);
  const auto kind = calib::name_of(reference.kind);
  if (!correction) {
    if (reference.kind != ReferenceKind::gravity) return {};
    return base::bad_input("the entry needs the local gravity itself, in m/s2", "--correction");
  }
  if (reference.kind == ReferenceKind::fixture_squareness) {
    return base::bad_input("squareness is an uncertainty alone: leave the correction out", "--correction");
  }
  if (*correction >= limits.correction_min && *correction <= limits.correction_max) return {};
  return base::bad_input(fmt::format("{} {} cannot be right for {}: {} to {} {} are taken", *correction, unit, kind,
                                     limits.correction_min, limits.correction_max, unit),
                         "--correction");
}

base::Status check_numbers(const ReferenceAddCommand& command, const calib::Reference& reference) {
  const double largest = limits_of(reference.kind).uncertainty;
  if (!(command.uncertainty > 0.0) || !(command.uncertainty <= largest)) {
    return base::bad_input(fmt::format("{} {} cannot be the uncertainty of {}: more than 0 and up to {} {} are taken",
                                       command.uncertainty, calib::printed_unit(reference.kind),
                                       calib::name_of(reference.kind), largest, calib::printed_unit(reference.kind)),
                           "--uncertainty");
  }
  if (!(command.coverage >= 1.0) || !(command.coverage <= kLargestCoverage)) {
    return base::bad_input(
        fmt::format("{} is no coverage factor; certificates use 1 to {}, mostly 2", command.coverage, kLargestCoverage),
        "--k");
  }
  return check_correction(reference, command.correction);
}

base::Status check_dates(const calib::Reference& reference, double now_s) {
  if (reference.issued_utc_s > now_s) {
    return base::bad_input("the certificate would be issued after today; see the clock too", "--issued");
  }
  if (reference.due_utc_s > reference.issued_utc_s) return {};
  return base::bad_input(fmt::format("is not after the day of issue, {}", iso_date(reference.issued_utc_s)), "--due");
}

base::Result<calib::Reference> reference_of(const ReferenceAddCommand& command, double now_s) {
  const auto lines = check_lines({{command.reference.name, "--name"}, {command.certificate, "--certificate"}});
  if (!lines) return base::forward_error(lines);
  const auto kind = kind_of(command.reference.kind);
  if (!kind) return base::forward_error(kind);
  const auto issued = date_of(command.issued, "--issued");
  if (!issued) return base::forward_error(issued);
  const auto due = date_of(command.due, "--due");
  if (!due) return base::forward_error(due);
  calib::Reference reference{{}, *kind, command.reference.name, command.certificate, {}, 0.0, *issued, *due};
  if (auto status = check_dates(reference, now_s); !status) return base::forward_error(status);
  if (auto status = check_numbers(command, reference); !status) return base::forward_error(status);
  // u = U / k  [JCGM 100:2008, 6.2.1]
  const double factor = calib::printed_per_si(*kind);
  reference.standard_uncertainty = command.uncertainty / command.coverage / factor;
  if (command.correction) reference.correction = *command.correction / factor;
  return reference;
}

/// The entries of one reference, the newest first; refuses a reference that has none.
base::Result<std::vector<ShownReference>> entries_of(const db::Catalog& catalog, const ReferenceName& name) {
  const auto kind = kind_of(name.kind);
  if (!kind) return base::forward_error(kind);
  auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return shown;
  std::erase_if(*shown, [&](const ShownReference& one) {
    return one.row.reference.kind != *kind || one.row.reference.name != name.name;
  });
  if (!shown->empty()) return shown;
  return base::bad_input(
      fmt::format("the register has no {} '{}'; 'soak reference list' shows what it has", name.kind, name.name),
      "--name");
}

/// Prints the entry with that id as it stands now.
base::Status print_entry(const db::Catalog& catalog, const std::string& record_id, Output& output) {
  auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return base::forward_error(shown);
  std::erase_if(*shown, [&](const ShownReference& one) { return one.row.reference.record_id != record_id; });
  if (output.json()) return output.print_json(references_document(*shown));
  for (const ShownReference& one : *shown) output.print(reference_text(one));
  return {};
}

/// The entry with that certificate, or the first, of entries_of().
base::Result<ShownReference> entry_with(const std::vector<ShownReference>& entries, const ReferenceName& name,
                                        const std::string& certificate) {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const ShownReference& one) {
    return certificate.empty() || one.row.reference.certificate == certificate;
  });
  if (found != entries.end()) return *found;
  return base::bad_input(fmt::format("{} '{}' has no certificate '{}'", name.kind, name.name, certificate),
                         "--certificate");
}

/// The entry that a waiver is for.
base::Result<calib::Reference> entry_to_waive(const db::Catalog& catalog, const ReferenceWaiveCommand& command) {
  const auto entries = entries_of(catalog, command.reference);
  if (!entries) return base::forward_error(entries);
  const auto found = entry_with(*entries, command.reference, command.certificate);
  if (!found) return base::forward_error(found);
  const calib::Reference& reference = found->row.reference;
  if (found->standing == Standing::withdrawn) {
    return base::bad_input(fmt::format("the entry of {} is withdrawn", describe(reference)), "--name");
  }
  // A waiver for an older certificate is for older recordings, whatever has become of the reference since.
  if (found->standing == Standing::retired && command.certificate.empty()) {
    return base::bad_input(fmt::format("{} is retired: it is not used any more", describe(reference)), "--name");
  }
  if (reference.due_utc_s - now_utc_s() > kDueSoon_s) {
    return base::bad_input(fmt::format("{} is good until {}: a waiver is signed when it is needed, at most 30 days "
                                       "before",
                                       describe(reference), iso_date(reference.due_utc_s)),
                           "--name");
  }
  return reference;
}

}  // namespace

base::Status run_reference_add(const ReferenceAddCommand& command, Output& output) {
  const double now_s = now_utc_s();
  auto reference = reference_of(command, now_s);
  if (!reference) return base::forward_error(reference);
  const std::string user = command.user.empty() ? user_name() : command.user;
  if (auto status = check_carried_line(user, "--user"); !status) return status;
  auto catalog = open_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto record_id = catalog->add_reference({*reference, user, now_s});
  if (!record_id) return base::forward_error(record_id);
  if (reference->due_utc_s <= now_s) output.note("warning: this certificate has expired already");
  return print_entry(*catalog, *record_id, output);
}

base::Status run_reference_list(const ReferenceListCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  auto shown = shown_register(*catalog, now_utc_s());
  if (!shown) return base::forward_error(shown);
  // The entry that stands for a reference comes first.
  const auto is_older = [](const ShownReference& newer, const ShownReference& older) {
    return newer.row.reference.kind == older.row.reference.kind && newer.row.reference.name == older.row.reference.name;
  };
  shown->erase(std::unique(shown->begin(), shown->end(), is_older), shown->end());
  if (output.json()) return output.print_json(references_document(*shown));
  output.print(shown->empty() ? "the register of references is empty\n" : references_table(*shown));
  return {};
}

base::Status run_reference_show(const ReferenceShowCommand& command, Output& output) {
  const auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto shown = entries_of(*catalog, command.reference);
  if (!shown) return base::forward_error(shown);
  if (output.json()) return output.print_json(references_document(*shown));
  for (const ShownReference& one : *shown) output.print(reference_text(one));
  return {};
}

base::Status run_reference_retire(const ReferenceRetireCommand& command, Output& output) {
  const std::string user = command.user.empty() ? user_name() : command.user;
  if (auto status = check_lines({{command.reason, "--reason"}, {user, "--user"}}); !status) return status;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto entries = entries_of(*catalog, command.reference);
  if (!entries) return base::forward_error(entries);
  const std::string record_id = entries->front().row.reference.record_id;
  if (auto status = catalog->retire_reference(record_id, {command.reason, user, now_utc_s()}); !status) return status;
  return print_entry(*catalog, record_id, output);
}

base::Status run_reference_withdraw(const ReferenceWithdrawCommand& command, Output& output) {
  const std::string user = command.user.empty() ? user_name() : command.user;
  if (auto status = check_lines({{command.reason, "--reason"}, {user, "--user"}}); !status) return status;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto entries = entries_of(*catalog, command.reference);
  if (!entries) return base::forward_error(entries);
  const auto found = entry_with(*entries, command.reference, command.certificate);
  if (!found) return base::forward_error(found);
  const std::string record_id = found->row.reference.record_id;
  if (auto status = catalog->withdraw_reference(record_id, {command.reason, user, now_utc_s()}); !status) return status;
  return print_entry(*catalog, record_id, output);
}

base::Status run_reference_waive(const ReferenceWaiveCommand& command, Output& output) {
  const std::string signer = command.signer.empty() ? user_name() : command.signer;
  if (auto status = check_lines({{command.reason, "--reason"}, {signer, "--signer"}}); !status) return status;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto reference = entry_to_waive(*catalog, command);
  if (!reference) return base::forward_error(reference);
  const auto key = read_secret_key(command.key);
  if (!key) return base::forward_error(key);
  const calib::Waiver unsigned_waiver{
      new_run_id(), reference->record_id, command.reason, signer, {}, std::floor(now_utc_s()), {}};
  const auto waiver = signed_waiver(unsigned_waiver, *reference, key->key);
  if (!waiver) return base::forward_error(waiver);
  if (auto status = catalog->add_waiver(*waiver); !status) return status;
  return print_entry(*catalog, reference->record_id, output);
}

}  // namespace soak::station
