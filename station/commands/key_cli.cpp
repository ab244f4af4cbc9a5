// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>

#include "station/commands/frame.h"
#include "station/commands/key_commands.h"

namespace soak::station::cli {
namespace {

void add_new(CLI::App& group, Request& request) {
  const auto options = std::make_shared<KeyNewCommand>();
  CLI::App* command = add_command(group, request, "new", "Make a key to sign calibration files with",
                                  "soak key new -o lab.key --comment 'Laboratory 1, 2027'", true);
  command->add_option("-o,--output", options->file, "File for the secret key; the public key goes beside it, FILE.pub")
      ->required()
      ->type_name("FILE");
  command->add_option("--comment", options->comment, "Whose key it is: stands in both files")->type_name("TEXT");
  command->callback(
      [options, &request] { request.action = [options](Output& output) { return run_key_new(*options, output); }; });
}

void add_show(CLI::App& group, Request& request) {
  const auto options = std::make_shared<KeyShowCommand>();
  CLI::App* command = add_command(group, request, "show", "A key's number, public key and comment; never the secret",
                                  "soak key show lab.key.pub", true);
  command->add_option("file", options->file, "Secret or public key")->required()->type_name("FILE");
  command->callback(
      [options, &request] { request.action = [options](Output& output) { return run_key_show(*options, output); }; });
}

void add_sign(CLI::App& group, Request& request) {
  const auto options = std::make_shared<KeySignCommand>();
  CLI::App* command =
      add_command(group, request, "sign", "Sign a calibration file, in place of a signature that it has",
                  "soak key sign SN0042.soakcal --key lab.key", true);
  command->add_option("file", options->file, "Calibration file")->required()->type_name("FILE.soakcal");
  command->add_option("--key", options->key, "Secret key")->required()->type_name("FILE");
  command->callback(
      [options, &request] { request.action = [options](Output& output) { return run_key_sign(*options, output); }; });
}

void add_verify(CLI::App& group, Request& request) {
  const auto options = std::make_shared<KeyVerifyCommand>();
  CLI::App* command =
      add_command(group, request, "verify", "Whether a calibration file is as somebody whom you trust has signed it",
                  "soak key verify SN0042.soakcal --key lab.key.pub", true);
  command->add_option("file", options->file, "Calibration file")->required()->type_name("FILE.soakcal");
  CLI::Option* key = command->add_option("--key", options->key, "Public key")->type_name("FILE.pub");
  CLI::Option* trusted =
      command->add_option("--trusted", options->trusted, "Folder of public keys (*.pub): any of them")
          ->type_name("DIR");
  key->excludes(trusted);
  command->callback([options, key, trusted, &request] {
    if (key->count() + trusted->count() == 0) throw CLI::RequiredError("--key FILE.pub or --trusted DIR");
    request.action = [options](Output& output) { return run_key_verify(*options, output); };
  });
}

}  // namespace

void register_key(CLI::App& program, Request& request) {
  CLI::App* group = add_group(program, "key", "Keys and signatures of calibration files");
  add_new(*group, request);
  add_show(*group, request);
  add_sign(*group, request);
  add_verify(*group, request);
}

}  // namespace soak::station::cli
