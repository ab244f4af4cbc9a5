// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/key_file.h"
#include "station/records/reference_entry.h"
#include "station/records/reference_register.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using calib::ReferenceKind;

/// Which reference a command is about.
struct ReferenceOptions {
  std::string kind;
  std::string name;
  std::string user;  ///< empty = the user that runs the program

  void declare_name(OptionList& options) {
    options.add("--kind KIND", &kind, "chamber_probe, fixture_squareness, level, gravity, supply or rate").required();
    options.add("--name NAME", &name, "Name of the reference in the laboratory").required();
  }
  void declare_user(OptionList& options) {
    options.add("--user NAME", &user, "Name for the record (default: the user that runs the program)");
  }
};

/// soak reference add: numbers in the unit of the kind, dates as "2027-03-01"
struct ReferenceAdd final : Command, ReferenceOptions {
  std::string certificate;
  std::string issued;
  std::string due;
  double uncertainty = 0.0;  ///< expanded, as the certificate states it
  double coverage = 2.0;     ///< its factor k
  std::optional<double> correction;

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

void ReferenceAdd::declare(OptionList& options) {
  declare_name(options);
  options.add("--certificate TEXT", &certificate, "Number of the certificate").required();
  options.add("--issued YYYY-MM-DD", &issued, "Date of the calibration").required();
  options.add("--due YYYY-MM-DD", &due, "Date on which it expires").required();
  options
      .add("--uncertainty U", &uncertainty,
           "Expanded uncertainty stated in the certificate, in K (chamber_probe), deg (fixture_squareness, level), "
           "m/s2 (gravity), V (supply) or ppm (rate)")
      .required();
  options.add("--k K", &coverage, "Coverage factor of the uncertainty").with_default();
  options.add("--correction X", &correction,
              "Value to add to the reference's reading, in the same unit; for gravity the value itself");
  declare_user(options);
}

/// soak reference list: one line per reference, its newest entry.
struct ReferenceList final : CatalogCommand {
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak reference show: all entries of one reference with waivers and campaigns.
struct ReferenceShow final : CatalogCommand, ReferenceOptions {
  void declare(OptionList& options) override { declare_name(options); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak reference retire
struct ReferenceRetire final : CatalogCommand, ReferenceOptions {
  std::string reason;

  void declare(OptionList& options) override {
    declare_name(options);
    options.add("--reason TEXT", &reason, "Reason, for the record").required();
    declare_user(options);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak reference withdraw: takes back an entry that was wrong.
struct ReferenceWithdraw final : CatalogCommand, ReferenceOptions {
  std::string certificate;  ///< of the entry; empty = the current one
  std::string reason;

  void declare(OptionList& options) override {
    declare_name(options);
    options.add("--certificate TEXT", &certificate, "An entry other than the current one");
    options.add("--reason TEXT", &reason, "What is wrong").required();
    declare_user(options);
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak reference waive: fails for an entry that is valid for more than 30 days yet, as nobody can judge so far ahead.
struct ReferenceWaive final : CatalogCommand, ReferenceOptions {
  std::string certificate;  ///< of the entry; empty = the current one
  std::string reason;
  std::string key;     ///< secret key file
  std::string signer;  ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    declare_name(options);
    options.add("--certificate TEXT", &certificate, "An older certificate, for older recordings");
    options.add("--reason TEXT", &reason, "Why it may be used").required();
    options.add("--key FILE", &key, "Secret key of the signer ('soak key new')").required();
    options.add("--signer NAME", &signer, "Name of the signer (default: the user that runs the program)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

base::Status check_lines(std::initializer_list<std::pair<const std::string&, const char*>> lines) {
  for (const auto& [text, option] : lines) {
    if (auto status = check_carried_line(text, option); !status) return status;
  }
  return {};
}

/// A mistake of an entry is in the option of the same name.
base::Error at_option(base::Error error) {
  error.where = "--" + error.where;
  return error;
}

base::Result<ReferenceKind> kind_of(const std::string& name) { return reference_kind(name).map_error(at_option); }

/// The entries of one reference, the newest first; fails (bad_input) if there are none.
base::Result<std::vector<ShownReference>> entries_of(const db::Catalog& catalog, const ReferenceOptions& command) {
  const auto kind = kind_of(command.kind);
  if (!kind) return base::forward_error(kind);
  auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return shown;
  std::erase_if(*shown, [&](const ShownReference& one) {
    return one.row.reference.kind != *kind || one.row.reference.name != command.name;
  });
  if (!shown->empty()) return shown;
  return base::bad_input(
      fmt::format("the register has no {} '{}': 'soak reference list' shows all", command.kind, command.name),
      "--name");
}

/// Prints the entry with that id in its present state.
base::Status print_entry(const db::Catalog& catalog, const std::string& record_id, Output& output) {
  auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return base::forward_error(shown);
  std::erase_if(*shown, [&](const ShownReference& one) { return one.row.reference.record_id != record_id; });
  if (output.json()) return output.print_json(references_document(*shown));
  for (const ShownReference& one : *shown) output.print(reference_text(one));
  return {};
}

/// The entry with that certificate, or the first, of entries_of().
base::Result<ShownReference> entry_with(const std::vector<ShownReference>& entries, const ReferenceOptions& command,
                                        const std::string& certificate) {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const ShownReference& one) {
    return certificate.empty() || one.row.reference.certificate == certificate;
  });
  if (found != entries.end()) return *found;
  return base::bad_input(fmt::format("{} '{}' has no certificate '{}'", command.kind, command.name, certificate),
                         "--certificate");
}

/// The entry that a waiver is signed for.
base::Result<calib::Reference> entry_to_waive(const db::Catalog& catalog, const ReferenceWaive& command) {
  const auto entries = entries_of(catalog, command);
  if (!entries) return base::forward_error(entries);
  const auto found = entry_with(*entries, command, command.certificate);
  if (!found) return base::forward_error(found);
  const calib::Reference& reference = found->row.reference;
  if (found->standing == ReferenceStanding::withdrawn) {
    return base::bad_input(fmt::format("the entry of {} was withdrawn", describe(reference)), "--name");
  }
  // A waiver for an older certificate is for older recordings, whatever has become of the reference since.
  if (found->standing == ReferenceStanding::retired && command.certificate.empty()) {
    return base::bad_input(fmt::format("{} is retired: it is no longer in use", describe(reference)), "--name");
  }
  if (reference.due_utc_s - now_utc_s() > kDueSoon_s) {
    return base::bad_input(fmt::format("{} is valid until {}: a waiver can be signed at most 30 days before",
                                       describe(reference), iso_date(reference.due_utc_s)),
                           "--name");
  }
  return reference;
}

base::Status ReferenceAdd::run(Output& output) {
  const double now_s = now_utc_s();
  const EnteredReference entered{kind, name, certificate, issued, due, uncertainty, coverage, correction};
  const auto reference = reference_from(entered, now_s).map_error(at_option);
  if (!reference) return base::forward_error(reference);
  const std::string who = user_name(user);
  if (auto status = check_carried_line(who, "--user"); !status) return status;
  auto catalog = open_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  const auto record_id = catalog->add_reference({*reference, who, now_s});
  if (!record_id) return base::forward_error(record_id);
  if (reference->due_utc_s <= now_s) output.note("warning: this certificate has already expired");
  return print_entry(*catalog, *record_id, output);
}

base::Status ReferenceList::run_with(db::Catalog& catalog, Output& output) {
  auto shown = shown_register(catalog, now_utc_s());
  if (!shown) return base::forward_error(shown);
  // The current entry of a reference comes first.
  const auto is_older = [](const ShownReference& newer, const ShownReference& older) {
    return newer.row.reference.kind == older.row.reference.kind && newer.row.reference.name == older.row.reference.name;
  };
  shown->erase(std::unique(shown->begin(), shown->end(), is_older), shown->end());
  if (output.json()) return output.print_json(references_document(*shown));
  output.print(shown->empty() ? "the register of references is empty\n" : references_table(*shown));
  return {};
}

base::Status ReferenceShow::run_with(db::Catalog& catalog, Output& output) {
  const auto shown = entries_of(catalog, *this);
  if (!shown) return base::forward_error(shown);
  if (output.json()) return output.print_json(references_document(*shown));
  for (const ShownReference& one : *shown) output.print(reference_text(one));
  return {};
}

base::Status ReferenceRetire::run_with(db::Catalog& catalog, Output& output) {
  const std::string who = user_name(user);
  if (auto status = check_lines({{reason, "--reason"}, {who, "--user"}}); !status) return status;
  const auto entries = entries_of(catalog, *this);
  if (!entries) return base::forward_error(entries);
  const std::string record_id = entries->front().row.reference.record_id;
  if (auto status = catalog.retire_reference(record_id, {reason, who, now_utc_s()}); !status) return status;
  return print_entry(catalog, record_id, output);
}

base::Status ReferenceWithdraw::run_with(db::Catalog& catalog, Output& output) {
  const std::string who = user_name(user);
  if (auto status = check_lines({{reason, "--reason"}, {who, "--user"}}); !status) return status;
  const auto entries = entries_of(catalog, *this);
  if (!entries) return base::forward_error(entries);
  const auto found = entry_with(*entries, *this, certificate);
  if (!found) return base::forward_error(found);
  const std::string record_id = found->row.reference.record_id;
  if (auto status = catalog.withdraw_reference(record_id, {reason, who, now_utc_s()}); !status) return status;
  return print_entry(catalog, record_id, output);
}

base::Status ReferenceWaive::run_with(db::Catalog& catalog, Output& output) {
  const std::string who = user_name(signer);
  if (auto status = check_lines({{reason, "--reason"}, {who, "--signer"}}); !status) return status;
  const auto reference = entry_to_waive(catalog, *this);
  if (!reference) return base::forward_error(reference);
  const auto secret_key = read_secret_key(key);
  if (!secret_key) return base::forward_error(secret_key);
  const calib::Waiver unsigned_waiver{new_run_id(), reference->record_id, reason, who, {}, std::floor(now_utc_s()), {}};
  const auto waiver = signed_waiver(unsigned_waiver, *reference, secret_key->key);
  if (!waiver) return base::forward_error(waiver);
  if (auto status = catalog.add_waiver(*waiver); !status) return status;
  return print_entry(catalog, reference->record_id, output);
}

}  // namespace

CommandGroup reference_commands() {
  return {"reference",
          "Register of references: certificates, due dates, waivers",
          {{"add", "Enter a certificate; it replaces older ones of the same reference",
            "soak reference add --kind chamber_probe --name 'probe 3' --certificate D-K-15048 --issued 2026-03-01 "
            "--due 2027-03-01 --uncertainty 0.05 --correction -0.02",
            std::make_shared<ReferenceAdd>()},
           {"list", "List all references, and which are expired or due within 30 days", "soak reference list",
            std::make_shared<ReferenceList>()},
           {"show", "Show all certificates of one reference, with waivers and campaigns",
            "soak reference show --kind chamber_probe --name 'probe 3'", std::make_shared<ReferenceShow>()},
           {"waive", "Sign a waiver that allows an expired reference to be used",
            "soak reference waive --kind level --name 'level 1' --reason 'new one is ordered' --key head-of-lab.key",
            std::make_shared<ReferenceWaive>()},
           {"retire", "Take a reference out of use",
            "soak reference retire --kind chamber_probe --name 'probe 3' --reason 'dropped'",
            std::make_shared<ReferenceRetire>()},
           {"withdraw", "Withdraw a wrong entry; then enter the certificate again",
            "soak reference withdraw --kind chamber_probe --name 'probe 3' --reason 'wrong date of issue'",
            std::make_shared<ReferenceWithdraw>()}}};
}

}  // namespace soak::station
