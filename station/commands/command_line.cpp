// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string_view>
#include <type_traits>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

/// What the command line asked for.
struct Request {
  std::string data;   ///< --data
  bool json = false;  ///< --json
  Command* command = nullptr;
};

CLI::Option* add_target(CLI::App& app, const Option& option) {
  return std::visit(
      [&](const auto& target) -> CLI::Option* {
        using Target = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<Target, bool*>) {
          return app.add_flag(option.name, *target, option.help);
        } else if constexpr (std::is_same_v<Target, OptionReader>) {
          const auto read = [target, name = option.name](const std::string& text) {
            if (const auto status = target(text); !status) throw CLI::ValidationError(name, status.error().message);
          };
          if (!option.takes_one) return app.add_option_function<std::string>(option.name, read, option.help);
          const auto read_each = [read](const std::vector<std::string>& texts) { std::ranges::for_each(texts, read); };
          return app.add_option_function<std::vector<std::string>>(option.name, read_each, option.help);
        } else {
          return app.add_option(option.name, *target, option.help);
        }
      },
      option.target);
}

/// The message of a value that is out of its limits or none of its choices; empty where it is right.
std::string mistake_in(const std::string& text, const Option& option) {
  if (!option.choices.empty() && std::ranges::find(option.choices, text) == option.choices.end()) {
    return fmt::format("'{}' is not one of {}", text, fmt::join(option.choices, ", "));
  }
  if (!option.limits) return {};
  double number = 0.0;
  const auto [low, high] = *option.limits;
  if (CLI::detail::lexical_cast(text, number) && number >= low && number <= high) return {};
  return fmt::format("'{}' is not a number from {} to {}", text, low, high);
}

void add_option(CLI::App& app, const Option& option) {
  CLI::Option* added = add_target(app, option);
  const std::string choices = fmt::format("{}", fmt::join(option.choices, "|"));
  if (!std::holds_alternative<bool*>(option.target)) added->type_name(choices.empty() ? option.value : choices);
  if (option.is_required) added->required();
  if (option.shows_default) added->capture_default_str();
  if (option.takes_one) added->allow_extra_args(false);
  if (option.limits || !option.choices.empty()) {
    added->check([option](const std::string& text) { return mistake_in(text, option); });
  }
  if (option.limits) {
    added->description(fmt::format("{} [{} to {}]", option.help, option.limits->first, option.limits->second));
  }
}

void add_options(CLI::App& app, const OptionList& list, const std::function<void()>& on_parsed) {
  for (const Option& option : list.options) add_option(app, option);
  for (const Option& option : list.options) {
    CLI::Option* added = app.get_option(option.name.substr(option.name.rfind(',') + 1));
    for (const std::string& other : option.excluded) added->excludes(app.get_option(other));
    for (const std::string& other : option.needed) added->needs(app.get_option(other));
  }
  app.callback([&app, one_required = list.one_required, on_parsed] {
    for (const auto& [names, text] : one_required) {
      const auto is_given = [&app](const std::string& name) { return app.get_option(name)->count() > 0; };
      if (std::ranges::none_of(names, is_given)) throw CLI::RequiredError(text);
    }
    on_parsed();
  });
}

void add_command(CLI::App& parent, const CommandEntry& entry, Request& request) {
  CLI::App* app = parent.add_subcommand(entry.name, entry.help);
  app->footer("Example:\n  " + entry.example + (entry.remark.empty() ? "" : "\n\n" + entry.remark));
  app->add_option("--data", request.data, "Data folder (default: $SOAK_DATA, else $XDG_DATA_HOME/soak)")
      ->type_name("DIR");
  if (entry.prints_json) app->add_flag("--json", request.json, "Print the result as one JSON document");
  OptionList list;
  entry.command->declare(list);
  add_options(*app, list, [command = entry.command.get(), &request] { request.command = command; });
}

void add_group(CLI::App& program, const CommandGroup& group, Request& request) {
  CLI::App* parent = &program;
  if (!group.name.empty()) {
    const auto known = program.get_subcommands([&](const CLI::App* app) { return app->get_name() == group.name; });
    parent = known.empty() ? program.add_subcommand(group.name, group.help)->require_subcommand(0, 1) : known.front();
  }
  for (const CommandEntry& entry : group.commands) add_command(*parent, entry, request);
}

/// Whether errors are wanted as JSON, also those of a command line that cannot be parsed.
bool asks_for_json(int argc, char** argv) {
  return std::any_of(argv + 1, argv + argc, [](const char* text) { return std::string_view(text) == "--json"; });
}

/// The innermost subcommand that was named.
const CLI::App& named_command(const CLI::App& program) {
  const auto named = program.get_subcommands();
  return named.empty() ? program : named_command(*named.front());
}

std::string full_name(const CLI::App& command) {
  return command.get_parent() == nullptr ? command.get_name()
                                         : full_name(*command.get_parent()) + " " + command.get_name();
}

int fail(Output& output, const base::Error& error) {
  output.print_error(error);
  return static_cast<int>(error.kind);
}

int perform(const Request& request, Output& output) {
  request.command->data = request.data.empty() ? request.command->data : request.data;
  const auto status = request.command->run(output);
  std::cout.flush();
  if (!status) return fail(output, status.error());
  if (std::cout) return 0;
  return fail(output, {base::ErrorKind::internal, "cannot write the results (is the disk full?)", "standard output"});
}

int parse_and_run(const Program& program, int argc, char** argv, Output& output) {
  Request request;
  CLI::App app(program.description, program.name);
  app.set_version_flag("--version", program.name + " " + software_version());
  app.footer(program.footer);
  if (program.command) {
    OptionList list;
    program.command->declare(list);
    add_options(app, list, [&] { request.command = program.command.get(); });
  } else {
    app.require_subcommand(0, 1);
  }
  for (const CommandGroup& group : program.groups) add_group(app, group, request);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version, std::cout, std::cerr);
  } catch (const CLI::ParseError& error) {
    return fail(output, {base::ErrorKind::bad_input,
                         fmt::format("{} ('{} --help' shows the usage)", error.what(), full_name(named_command(app))),
                         "command line"});
  }
  if (request.command != nullptr) return perform(request, output);
  std::cout << named_command(app).help();
  return 0;
}

/// The option that an argument is the value of, else its number.
std::string place_of(char** argv, int i) {
  const std::string_view before = i > 1 ? argv[i - 1] : "";
  return before.starts_with("-") ? std::string(before) : fmt::format("argument {}", i);
}

}  // namespace

Option& OptionList::add(std::string_view name, OptionTarget target, std::string help) {
  const std::size_t blank = std::min(name.find(' '), name.size());
  const std::size_t value = std::min(blank + 1, name.size());
  options.push_back(
      {std::string(name.substr(0, blank)), std::string(name.substr(value)), std::move(target), std::move(help)});
  return options.back();
}

void OptionList::require_one_of(std::vector<std::string> names, std::string text) {
  one_required.emplace_back(std::move(names), std::move(text));
}

OptionReader number_list(std::vector<double>& numbers, double low, double high, std::string must_be) {
  return [&numbers, low, high, must_be = std::move(must_be)](const std::string& list) -> base::Status {
    numbers.clear();
    for (std::size_t first = 0; first <= list.size();) {
      const std::size_t comma = std::min(list.find(',', first), list.size());
      const auto number = base::parse_double(std::string_view(list).substr(first, comma - first));
      if (!number || *number < low || *number > high) return base::bad_input("must be " + must_be, {});
      numbers.push_back(*number);
      first = comma + 1;
    }
    return {};
  };
}

int run_program(const Program& program, int argc, char** argv) {
  Output output(std::cout, std::cerr, asks_for_json(argc, argv), ::isatty(STDERR_FILENO) != 0, program.name);
  if (std::getenv("SOAK_PROGRESS") != nullptr) output.tell_each_percent();
  try {
    for (int i = 1; i < argc; ++i) {
      if (base::is_utf8(argv[i])) continue;
      return fail(output, {base::ErrorKind::bad_input, "the argument is not UTF-8 text", place_of(argv, i)});
    }
    if (!program.command) catch_signals();
    return parse_and_run(program, argc, argv, output);
  } catch (const std::exception& error) {
    return fail(output, {base::ErrorKind::internal, error.what(), program.name});
  }
}

}  // namespace soak::station
