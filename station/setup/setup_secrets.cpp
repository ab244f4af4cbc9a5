// SPDX-License-Identifier: Apache-2.0
#include "station/setup/setup_secrets.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <system_error>

#include "base/file_descriptor.h"
#include "db/durable.h"

namespace soak::station {
namespace {

constexpr mode_t kOwnerOnly = 0600;

std::string file_or(const std::string& file, const char* usual) { return file.empty() ? usual : file; }

}  // namespace

std::string password_file_of(const EnteredMail& mail) {
  return mail.password.empty() ? mail.password_file : file_or(mail.password_file, kMailPasswordFile);
}

std::string url_file_of(const EnteredWebhook& webhook) { return file_or(webhook.url_file, kWebhookUrlFile); }

std::string token_file_of(const EnteredWebhook& webhook) {
  return webhook.token.empty() ? webhook.token_file : file_or(webhook.token_file, kWebhookTokenFile);
}

std::vector<SetupSecret> secrets_of(const SetupForm& form) {
  std::vector<SetupSecret> secrets;
  const auto add = [&](const std::string& file, const std::string& line) {
    if (!line.empty()) secrets.push_back({file, line});
  };
  if (form.mail) add(password_file_of(*form.mail), form.mail->password);
  if (form.webhook && !form.webhook->url_is_open) add(url_file_of(*form.webhook), form.webhook->url);
  if (form.webhook) add(token_file_of(*form.webhook), form.webhook->token);
  return secrets;
}

AlarmSecrets alarm_secrets_of(const SetupForm& form) {
  AlarmSecrets secrets;
  if (form.mail) secrets.password = form.mail->password;
  if (form.webhook) secrets.url = form.webhook->url;
  if (form.webhook) secrets.token = form.webhook->token;
  return secrets;
}

base::Status write_with_mode(const std::filesystem::path& file, std::string_view text, std::filesystem::perms mode) {
  std::error_code ignored;
  const std::filesystem::path found = std::filesystem::weakly_canonical(file, ignored);
  const std::filesystem::path target = found.empty() ? file : found;
  const std::filesystem::path partial = target.string() + ".new";
  std::filesystem::remove(partial, ignored);
  bool is_written = false;
  int error = 0;
  {
    const base::FileDescriptor opened(::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly));
    is_written = opened && ::write(opened.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
                 ::fchmod(opened.get(), static_cast<mode_t>(mode)) == 0;
    error = errno;
  }
  auto kept = is_written
                  ? db::rename_durably(partial, target)
                  : base::Status(base::fail(base::ErrorKind::internal,
                                            "cannot write: " + std::generic_category().message(error), file.string()));
  if (!kept) std::filesystem::remove(partial, ignored);
  return kept;
}

base::Status write_secrets(const std::filesystem::path& folder, const std::vector<SetupSecret>& secrets) {
  constexpr auto kMode = static_cast<std::filesystem::perms>(kOwnerOnly);
  for (const SetupSecret& secret : secrets) {
    if (auto written = write_with_mode(folder / secret.file, secret.line + "\n", kMode); !written) return written;
  }
  return {};
}

}  // namespace soak::station
