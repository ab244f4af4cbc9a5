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

base::Status write_secret(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path partial = file.string() + ".new";
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  bool is_written = false;
  int error = 0;
  {
    const base::FileDescriptor opened(::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly));
    is_written = opened && ::write(opened.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
    error = errno;
  }
  auto kept = is_written
                  ? db::rename_durably(partial, file)
                  : base::Status(base::fail(base::ErrorKind::internal,
                                            "cannot write: " + std::generic_category().message(error), file.string()));
  if (!kept) std::filesystem::remove(partial, ignored);
  return kept;
}

}  // namespace

std::vector<SetupSecret> secrets_of(const SetupForm& form) {
  std::vector<SetupSecret> secrets;
  const auto add = [&](const char* file, const std::string& line) {
    if (!line.empty()) secrets.push_back({file, line});
  };
  if (form.mail) add(kMailPasswordFile, form.mail->password);
  if (form.webhook) add(kWebhookUrlFile, form.webhook->url);
  if (form.webhook) add(kWebhookTokenFile, form.webhook->token);
  return secrets;
}

AlarmSecrets alarm_secrets_of(const SetupForm& form) {
  AlarmSecrets secrets;
  if (form.mail) secrets.password = form.mail->password;
  if (form.webhook) secrets.url = form.webhook->url;
  if (form.webhook) secrets.token = form.webhook->token;
  return secrets;
}

base::Status write_secrets(const std::filesystem::path& folder, const std::vector<SetupSecret>& secrets) {
  for (const SetupSecret& secret : secrets) {
    if (auto written = write_secret(folder / secret.file, secret.line + "\n"); !written) return written;
  }
  return {};
}

}  // namespace soak::station
