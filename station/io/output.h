// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// Where a command writes: results to standard output, as text or as one JSON document; everything else to standard
/// error.
class Output {
 public:
  /// Errors and remarks begin with the name of the `program`.
  Output(std::ostream& out, std::ostream& err, bool json, bool progress_bar, std::string program = "soak")
      : out_(out), err_(err), json_(json), progress_bar_(progress_bar), program_(std::move(program)) {}

  /// Whether --json was given: then print_json() is called once and print() never.
  [[nodiscard]] bool json() const { return json_; }

  void print(std::string_view text);
  /// Passes on at once what was printed.
  void flush();
  /// Prints the document. Refuses (internal) one that holds NaN or infinity: JSON has no such numbers.
  [[nodiscard]] base::Status print_json(const nlohmann::json& document);
  /// Prints {"`key`": [...]} one element after the other, so that a long list needs no memory. Stops at an element that
  /// cannot be had; what was printed by then is no whole document.
  [[nodiscard]] base::Status print_json_list(std::string_view key, std::size_t count,
                                             const std::function<base::Result<nlohmann::json>(std::size_t)>& element);
  /// A remark for the user on standard error.
  void note(std::string_view text);
  /// An error on standard error: "soak: where: message", or {"error": {"code", "message", "where"}}.
  void print_error(const base::Error& error);

  /// A callback for long work, which gets the share that is done. It draws a bar on a terminal; anywhere else, and
  /// without --json, it writes a line each minute, with the time at which the work will be done if it goes on like
  /// that; after tell_each_percent() a line for each percent instead of either. Returns false once the user has pressed
  /// Ctrl-C.
  [[nodiscard]] std::function<bool(double)> progress(std::string_view what);
  /// Says to a program that listens what the command does from now on, of which nobody knows how far it is: "soak:
  /// searching: ...". Says nothing to anybody else.
  void begin(std::string_view what);
  /// From now on long work says how far it is to a program that listens ($SOAK_PROGRESS): "soak: fitting: 12 %".
  void tell_each_percent() { tells_each_percent_ = true; }
  /// Ends a bar that was drawn.
  void end_progress();

 private:
  std::ostream& out_;
  std::ostream& err_;
  bool json_;
  bool progress_bar_;
  std::string program_;
  bool tells_each_percent_ = false;
  bool bar_is_drawn_ = false;
};

/// Makes Ctrl-C (SIGINT) and SIGTERM set a flag that interrupted() tells of, and writing past a file size limit an
/// error of the write.
void catch_signals();
[[nodiscard]] bool interrupted();

/// The number, or null where it is not finite or absent.
[[nodiscard]] nlohmann::json number_or_null(double value);
[[nodiscard]] nlohmann::json number_or_null(const std::optional<double>& value);

/// A plain table: columns as wide as their widest cell, numbers to the right.
[[nodiscard]] std::string text_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace soak::station
