// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "settings/reader.h"

namespace soak::station {

enum class MailSecurity : std::uint8_t {
  none,
  starttls,  ///< in the clear until both have agreed on TLS (RFC 3207)
  tls,       ///< from the first byte on (RFC 8314)
};

/// Where alarms go by mail.
struct MailTarget {
  std::string host;
  int port = 0;
  MailSecurity security = MailSecurity::starttls;
  std::string from;             ///< address
  std::vector<std::string> to;  ///< addresses
  std::string user;             ///< empty = the server does not ask
  std::filesystem::path password_file;
  std::filesystem::path certificate;  ///< PEM that the server's certificate must be signed by; empty = the system's
};

/// Where alarms go by HTTP.
struct WebhookTarget {
  std::string url;                 ///< empty = in url_file
  std::filesystem::path url_file;  ///< where the address is itself a secret
  std::filesystem::path token_file;
  std::filesystem::path certificate;  ///< as of MailTarget
};

/// [alarms] of the station's configuration: docs/station-config.md.
struct AlarmConfig {
  std::optional<MailTarget> mail;
  std::optional<WebhookTarget> webhook;
};

/// Reads [alarms] of a station's configuration; paths are relative to `folder`. Mistakes are recorded in the table.
[[nodiscard]] AlarmConfig read_alarm_config(const settings::Table& root, const std::filesystem::path& folder);

/// The one line of a file with a secret. Refuses (bad_input) a file that others than its owner and group may read, that
/// its group may write, that cannot be read, or that holds anything but one line of plain text.
[[nodiscard]] base::Result<std::string> read_secret_line(const std::filesystem::path& file);

/// Refuses (bad_input) what is no http:// or https:// address of a host, and one without TLS to another machine where
/// `with_token`: everybody on the way would read the token.
[[nodiscard]] base::Status check_webhook_url(const std::string& url, bool with_token);

}  // namespace soak::station
