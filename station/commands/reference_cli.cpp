// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/reference_commands.h"

namespace soak::station::cli {
namespace {

/// --kind and --name.
void add_name(CLI::App& command, ReferenceName& reference) {
  command.add_option("--kind", reference.kind, "chamber_probe, fixture_squareness, level, gravity, supply or rate")
      ->required()
      ->type_name("KIND");
  command.add_option("--name", reference.name, "What the laboratory calls it")->required()->type_name("NAME");
}

void add_user(CLI::App& command, std::string& user) {
  command.add_option("--user", user, "Who does it (else whoever is logged in)")->type_name("NAME");
}

void register_add(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ReferenceAddCommand>();
  CLI::App* command = add_command(
      group, request, "add", "Enter a certificate into the register; it supersedes the older ones",
      "soak reference add --kind chamber_probe --name 'probe 3' --certificate D-K-15048 --issued 2026-03-01 "
      "--due 2027-03-01 --uncertainty 0.05 --correction -0.02",
      true);
  add_name(*command, options->reference);
  command->add_option("--certificate", options->certificate, "Its number")->required()->type_name("TEXT");
  command->add_option("--issued", options->issued, "Day of the calibration")->required()->type_name("YYYY-MM-DD");
  command->add_option("--due", options->due, "Day on which it expires")->required()->type_name("YYYY-MM-DD");
  command
      ->add_option("--uncertainty", options->uncertainty,
                   "Expanded uncertainty on the certificate: K, deg, deg, m/s2, V or ppm, in the order of the kinds")
      ->required()
      ->type_name("U");
  command->add_option("--k", options->coverage, "Coverage factor of that")->type_name("K")->capture_default_str();
  command
      ->add_option("--correction", options->correction,
                   "Added to what the reference says, in the same unit; of gravity the value itself")
      ->type_name("X");
  add_user(*command, options->user);
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_reference_add(*options, output); };
  });
}

void register_list(CLI::App& group, Request& request) {
  CLI::App* command = add_command(group, request, "list", "All references, and which are expired or due within 30 days",
                                  "soak reference list", true);
  command->callback([&request] {
    request.action = [data = request.data](Output& output) { return run_reference_list({data}, output); };
  });
}

void register_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ReferenceShowCommand>();
  CLI::App* command = add_command(group, request, "show", "All certificates of one reference, waivers and campaigns",
                                  "soak reference show --kind chamber_probe --name 'probe 3'", true);
  add_name(*command, options->reference);
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_reference_show(*options, output); };
  });
}

void register_retire(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ReferenceRetireCommand>();
  CLI::App* command =
      add_command(group, request, "retire", "Take a reference out of use",
                  "soak reference retire --kind chamber_probe --name 'probe 3' --reason 'dropped'", true);
  add_name(*command, options->reference);
  command->add_option("--reason", options->reason, "Why")->required()->type_name("TEXT");
  add_user(*command, options->user);
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_reference_retire(*options, output); };
  });
}

void register_withdraw(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ReferenceWithdrawCommand>();
  CLI::App* command = add_command(
      group, request, "withdraw", "Take back a wrong entry; then enter the certificate again",
      "soak reference withdraw --kind chamber_probe --name 'probe 3' --reason 'day of issue mistyped'", true);
  add_name(*command, options->reference);
  command->add_option("--certificate", options->certificate, "Another entry than the one that counts now")
      ->type_name("TEXT");
  command->add_option("--reason", options->reason, "What is wrong")->required()->type_name("TEXT");
  add_user(*command, options->user);
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_reference_withdraw(*options, output); };
  });
}

void register_waive(CLI::App& group, Request& request) {
  const auto options = std::make_shared<ReferenceWaiveCommand>();
  CLI::App* command = add_command(group, request, "waive", "Sign for the use of an expired reference",
                                  "soak reference waive --kind level --name 'level 1' --reason 'new one is ordered' "
                                  "--key head-of-lab.key",
                                  true);
  add_name(*command, options->reference);
  command->add_option("--certificate", options->certificate, "An older certificate, for older recordings")
      ->type_name("TEXT");
  command->add_option("--reason", options->reason, "Why it may be used")->required()->type_name("TEXT");
  command->add_option("--key", options->key, "Secret key of the signer ('soak key new')")
      ->required()
      ->type_name("FILE");
  command->add_option("--signer", options->signer, "Name of the signer (else whoever is logged in)")->type_name("NAME");
  command->callback([options, &request] {
    options->data = request.data;
    request.action = [options](Output& output) { return run_reference_waive(*options, output); };
  });
}

}  // namespace

void register_reference(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "reference", "The register of references: certificates, due dates, waivers");
  register_add(*group, request);
  register_list(*group, request);
  register_show(*group, request);
  register_waive(*group, request);
  register_retire(*group, request);
  register_withdraw(*group, request);
}

}  // namespace soak::station::cli
