// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/config/alarm_config.h"

namespace soak::station {

/// What is sent to people: the document of a webhook (docs/schema/alarm-message.schema.json), and the text of a mail.
struct AlarmMessage {
  std::string subject;      ///< one line
  std::string text;         ///< lines, each ended
  nlohmann::json document;  ///< for programs
};

/// A way to people. Any thread may call; each call takes half a minute at most.
class Delivery {
 public:
  virtual ~Delivery() = default;
  Delivery() = default;
  Delivery(const Delivery&) = delete;
  Delivery& operator=(const Delivery&) = delete;

  /// "mail" or "webhook".
  [[nodiscard]] virtual std::string way() const = 0;
  /// Where it goes, for people and for the log: addresses, or the webhook's host alone.
  [[nodiscard]] virtual std::string destination() const = 0;
  /// Hands the message to the server. Fails (device) where that cannot be reached or does not take it, with the number
  /// that it answers; secrets are in no error. `stop` ends it early.
  [[nodiscard]] virtual base::Status send(const AlarmMessage& message, const std::atomic<bool>& stop) const = 0;
};

/// Mail by SMTP (RFC 5321): taken once the server takes it for one of its mailboxes. Refuses (bad_input) a password
/// file that read_secret_line() refuses.
[[nodiscard]] base::Result<std::unique_ptr<Delivery>> mail_delivery(const MailTarget& target);

/// POST of the document (application/json) to a webhook: any status from 200 to 299 takes it; redirects are not
/// followed. Refuses (bad_input) files that read_secret_line() refuses, and an address that check_webhook_url() does.
[[nodiscard]] base::Result<std::unique_ptr<Delivery>> webhook_delivery(const WebhookTarget& target);

/// Secrets that are not read from files; empty = none.
struct AlarmSecrets {
  std::string password;  ///< of the mail's user
  std::string url;       ///< of the webhook
  std::string token;     ///< of the webhook
};

/// Those that somebody has entered, with these secrets in place of the files that are named.
[[nodiscard]] std::vector<std::unique_ptr<Delivery>> deliveries_of(const AlarmConfig& config, AlarmSecrets secrets);

/// Those that the configuration names.
[[nodiscard]] base::Result<std::vector<std::unique_ptr<Delivery>>> deliveries_of(const AlarmConfig& config);

}  // namespace soak::station
