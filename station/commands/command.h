// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::db {
class Catalog;
}

/// Commands as data: a command is a class with its options, their declaration and its work, all in one file. Only
/// command_line.cpp knows the library that parses command lines.
namespace soak::station {

/// Reads the value of an option that is more than one number or text. The message of its error follows the option's
/// name.
using OptionReader = std::function<base::Status(const std::string& text)>;

/// Where the value of an option goes. bool: a flag; optional: stays absent where the option is not given; vector: may
/// be given several times.
using OptionTarget =
    std::variant<bool*, int*, double*, std::size_t*, std::string*, std::vector<std::string>*, std::optional<int>*,
                 std::optional<double>*, std::optional<std::size_t>*, std::optional<std::string>*, OptionReader>;

/// One option or argument of a command.
struct Option {
  std::string name;   ///< "--unit", "-o,--output"; without dashes an argument, known by its place
  std::string value;  ///< what stands for the value in the help: "SN"; empty for a flag
  OptionTarget target;
  std::string help;
  bool is_required = false;
  bool shows_default = false;
  bool takes_one = false;                                ///< several values need the option's name before each
  std::optional<std::pair<double, double>> limits = {};  ///< smallest and largest number
  std::vector<std::string> choices = {};                 ///< empty = any text
  std::vector<std::string> excluded = {};                ///< options that cannot be given together with this one
  std::vector<std::string> needed = {};                  ///< options that must be given together with this one

  Option& required() { return is_required = true, *this; }
  Option& with_default() { return shows_default = true, *this; }
  Option& one_each() { return takes_one = true, *this; }
  Option& range(double low, double high) { return limits = {low, high}, *this; }
  Option& one_of(std::vector<std::string> values) { return choices = std::move(values), *this; }
  Option& excludes(std::string other) { return excluded.push_back(std::move(other)), *this; }
  Option& needs(std::string other) { return needed.push_back(std::move(other)), *this; }
};

/// All options of a command.
struct OptionList {
  std::vector<Option> options;
  /// Names of options of which one must be given, and how the error names them.
  std::vector<std::pair<std::vector<std::string>, std::string>> one_required;

  /// `name` is that of the option, a blank, and what stands for its value in the help: "--unit SN", "--all".
  Option& add(std::string_view name, OptionTarget target, std::string help);
  void require_one_of(std::vector<std::string> names, std::string text);
};

/// A reader of numbers from `low` to `high` between commas. `must_be` says in an error what is right.
[[nodiscard]] OptionReader number_list(std::vector<double>& numbers, double low, double high, std::string must_be);

/// A command: members that hold its options, and its work.
class Command {
 public:
  Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  virtual ~Command() = default;

  /// Lists the options; called once, before the command line is read.
  virtual void declare(OptionList& options) { static_cast<void>(options); }
  /// Called once all options have been read and checked.
  [[nodiscard]] virtual base::Status run(Output& output) = 0;

  std::string data;  ///< --data, an option of every command of `soak`: the data folder; empty = the default one
};

/// A command that works with the catalog of an existing data folder.
class CatalogCommand : public Command {
 public:
  base::Status run(Output& output) final;
  /// The work, with the open catalog.
  [[nodiscard]] virtual base::Status run_with(db::Catalog& catalog, Output& output) = 0;

 protected:
  /// open_existing_catalog(), unless the command needs another way.
  [[nodiscard]] virtual base::Result<db::Catalog> open_data() const;
};

/// A command as the help shows it.
struct CommandEntry {
  std::string name;
  std::string help;
  std::string example;
  std::shared_ptr<Command> command;
  bool prints_json = true;  ///< it has the option --json
  std::string remark = {};  ///< below the example
};

/// Commands of one subject: `soak runs list`, `soak runs show`. Without a name they are commands of the program itself.
/// Groups of the same name are one group.
struct CommandGroup {
  std::string name;
  std::string help;
  std::vector<CommandEntry> commands;
};

/// A program: its commands, or the one thing that it does.
struct Program {
  std::string name;
  std::string description;
  std::string footer;
  std::vector<CommandGroup> groups;
  std::shared_ptr<Command> command = {};
};

/// Parses the command line, runs the command and prints its error. Returns the exit status.
int run_program(const Program& program, int argc, char** argv);

/// The commands of `soak`, one function per source file of this folder.
CommandGroup import_commands();
CommandGroup run_commands();
CommandGroup run_show_commands();
CommandGroup run_drop_commands();
CommandGroup fit_commands();
CommandGroup merge_commands();
CommandGroup archive_commands();
CommandGroup export_commands();
CommandGroup eval_commands();
CommandGroup correct_commands();
CommandGroup verify_commands();
CommandGroup release_commands();
CommandGroup model_commands();
CommandGroup model_compare_commands();
CommandGroup unit_commands();
CommandGroup type_commands();
CommandGroup campaign_commands();
CommandGroup procedure_commands();
CommandGroup signal_commands();
CommandGroup key_commands();
CommandGroup check_commands();
CommandGroup report_commands();
CommandGroup reference_commands();
CommandGroup gap_commands();
CommandGroup chamber_commands();
CommandGroup make_safe_commands();
CommandGroup doctor_commands();
CommandGroup event_commands();
CommandGroup backup_commands();
CommandGroup user_commands();
CommandGroup alarm_commands();
CommandGroup nav_commands();
CommandGroup plan_commands();

}  // namespace soak::station
