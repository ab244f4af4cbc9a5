// SPDX-License-Identifier: Apache-2.0
#include "station/config/alarm_config.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "station/http/address.h"
#include "station/io/text.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using settings::Table;

constexpr std::size_t kLongestAddress = 254;  // RFC 5321, 4.5.3.1.3, without the brackets

/// What a server and a header of a message take without quotes. Others are allowed (RFC 5321, 4.1.2), and nobody has
/// them.
bool is_mail_address(std::string_view text) {
  const auto at = text.find('@');
  const auto is_plain = [](char c) {
    return c > ' ' && c < 0x7F && std::string_view("<>()[]\\,;:\"").find(c) == std::string_view::npos;
  };
  return text.size() <= kLongestAddress && at != 0 && at != std::string_view::npos && at + 1 < text.size() &&
         text.find('@', at + 1) == std::string_view::npos && std::ranges::all_of(text, is_plain);
}

void check_address(const Table& table, std::string_view key, const std::string& address) {
  if (is_mail_address(address)) return;
  table.refuse(key, fmt::format("'{}' is not the address of a mailbox, such as lab@example.org", address));
}

std::filesystem::path file_in(const Table& table, std::string_view key, const std::filesystem::path& folder) {
  const std::string text = table.text(key, "");
  return text.empty() ? std::filesystem::path() : (folder / text).lexically_normal();
}

/// RFC 6409 (587) and RFC 8314 (465) for who hands a message in; 25 between servers of one house.
int usual_port(MailSecurity security) {
  if (security == MailSecurity::tls) return 465;
  return security == MailSecurity::starttls ? 587 : 25;
}

MailTarget read_mail(const Table& table, const std::filesystem::path& folder) {
  using enum MailSecurity;
  MailTarget mail;
  mail.host = table.text("host");
  if (mail.host.find_first_of(" /@:") != std::string::npos || !base::is_plain_line(mail.host)) {
    table.refuse("host", "'host' must be the name or the IPv4 address of a mail server; its port is 'port'");
  }
  mail.security =
      table.choice<MailSecurity>("security", {{"none", none}, {"starttls", starttls}, {"tls", tls}}, mail.security);
  mail.port = table.whole("port", {1, 65535}, usual_port(mail.security));
  mail.from = table.text("from");
  check_address(table, "from", mail.from);
  mail.to = table.texts("to", settings::kRequired);
  if (mail.to.empty() || mail.to.size() > 20) table.refuse("to", "'to' must list 1 to 20 addresses");
  for (const std::string& address : mail.to) check_address(table, "to", address);
  mail.user = table.text("user", "");
  mail.password_file = file_in(table, "password_file", folder);
  mail.certificate = file_in(table, "certificate", folder);
  if (mail.user.empty() != mail.password_file.empty()) {
    table.refuse("user", "'user' and 'password_file' belong together");
  }
  if (!mail.user.empty() && mail.security == none) {
    table.refuse("security", "a password is sent over TLS only: 'security' must be \"starttls\" or \"tls\"");
  }
  return mail;
}

WebhookTarget read_webhook(const Table& table, const std::filesystem::path& folder) {
  WebhookTarget webhook;
  webhook.url = table.text("url", "");
  webhook.url_file = file_in(table, "url_file", folder);
  webhook.token_file = file_in(table, "token_file", folder);
  webhook.certificate = file_in(table, "certificate", folder);
  if (webhook.url.empty() == webhook.url_file.empty()) {
    table.refuse("url", "a webhook needs one of 'url' and 'url_file' (where the address is itself a secret)");
  } else if (!webhook.url.empty()) {
    const auto fits = check_webhook_url(webhook.url, !webhook.token_file.empty());
    if (!fits) table.refuse("url", "'url' " + fits.error().message);
  }
  return webhook;
}

}  // namespace

AlarmConfig read_alarm_config(const Table& root, const std::filesystem::path& folder) {
  AlarmConfig config;
  const auto table = root.table("alarms");
  if (!table) return config;
  if (const auto mail = table->table("mail")) config.mail = read_mail(*mail, folder);
  if (const auto webhook = table->table("webhook")) config.webhook = read_webhook(*webhook, folder);
  return config;
}

base::Result<std::string> read_secret_line(const std::filesystem::path& file) {
  struct stat status{};
  if (::stat(file.c_str(), &status) != 0) {
    return base::bad_input("cannot be read: " + std::generic_category().message(errno), file.string());
  }
  if ((status.st_mode & (S_IRWXO | S_IWGRP)) != 0) {
    return base::bad_input(
        fmt::format("others may read or write this secret (mode {:04o}): 'chmod 600' the file, and change "
                    "the secret if somebody may have copied it",
                    status.st_mode & 07777U),
        file.string());
  }
  auto text = read_text_file(file);
  if (!text) return text;
  while (!text->empty() && (text->back() == '\n' || text->back() == '\r')) text->pop_back();
  if (auto line = check_text_line(*text, file.string()); !line) return base::forward_error(line);
  return text;
}

base::Status check_webhook_url(const std::string& url, bool with_token) {
  const bool tls = url.starts_with("https://");
  const std::size_t begin = url.find("//") + 2;
  const std::string authority =
      tls || url.starts_with("http://") ? url.substr(begin, url.find_first_of("/?#", begin) - begin) : "";
  const bool plain = std::ranges::all_of(url, [](char c) { return c > ' ' && c < 0x7F; });
  if (authority.empty() || authority.find('@') != std::string::npos || !plain) {
    return base::bad_input(
        "must be an address such as https://chat.example.org/hooks/soak, without a name or password in it");
  }
  if (with_token && !tls && !is_loopback({host_of(authority), 0})) {
    return base::bad_input("must begin with https://: a token is sent over TLS only");
  }
  return {};
}

}  // namespace soak::station
