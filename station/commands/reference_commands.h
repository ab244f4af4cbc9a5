// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// Which reference a command is about, as it was typed.
struct ReferenceName {
  std::string kind;
  std::string name;
};

/// soak reference add: numbers in the unit of the kind, dates as "2027-03-01"
struct ReferenceAddCommand {
  std::string data;
  ReferenceName reference;
  std::string certificate;
  std::string issued;
  std::string due;
  double uncertainty = 0.0;  ///< expanded, as the certificate states it
  double coverage = 2.0;     ///< its factor k
  std::optional<double> correction;
  std::string user;  ///< empty = whoever is logged in
};

/// soak reference list
struct ReferenceListCommand {
  std::string data;
};

/// soak reference show
struct ReferenceShowCommand {
  std::string data;
  ReferenceName reference;
};

/// soak reference retire
struct ReferenceRetireCommand {
  std::string data;
  ReferenceName reference;
  std::string reason;
  std::string user;
};

/// soak reference withdraw
struct ReferenceWithdrawCommand {
  std::string data;
  ReferenceName reference;
  std::string certificate;  ///< of the entry; empty = the one that stands for the reference now
  std::string reason;
  std::string user;
};

/// soak reference waive
struct ReferenceWaiveCommand {
  std::string data;
  ReferenceName reference;
  std::string certificate;  ///< of the entry; empty = the one that stands for the reference now
  std::string reason;
  std::string key;     ///< secret key file
  std::string signer;  ///< empty = whoever is logged in
};

[[nodiscard]] base::Status run_reference_add(const ReferenceAddCommand& command, Output& output);
/// One line per reference: its newest entry.
[[nodiscard]] base::Status run_reference_list(const ReferenceListCommand& command, Output& output);
/// All entries of one reference with waivers and campaigns.
[[nodiscard]] base::Status run_reference_show(const ReferenceShowCommand& command, Output& output);
[[nodiscard]] base::Status run_reference_retire(const ReferenceRetireCommand& command, Output& output);
/// Takes back an entry that was wrong.
[[nodiscard]] base::Status run_reference_withdraw(const ReferenceWithdrawCommand& command, Output& output);
/// Refuses an entry that is good for more than 30 days yet: nobody can know what speaks for it then.
[[nodiscard]] base::Status run_reference_waive(const ReferenceWaiveCommand& command, Output& output);

}  // namespace soak::station
