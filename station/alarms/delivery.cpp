// SPDX-License-Identifier: Apache-2.0
// The one place that knows libcurl.
#include "station/alarms/delivery.h"

#include <curl/curl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "station/http/address.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

constexpr long kConnect_s = 10;
constexpr long kWhole_s = 30;
constexpr long kReply_s = 10;  ///< of a mail server, to one command
constexpr long kHttpOk = 200;
constexpr long kHttpRedirect = 300;

struct FreeHandle {
  void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
};
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
struct FreeMime {
  void operator()(curl_mime* mime) const { curl_mime_free(mime); }
};
using Handle = std::unique_ptr<CURL, FreeHandle>;

class Lines {
 public:
  void add(const std::string& line) { list_.reset(curl_slist_append(list_.release(), line.c_str())); }
  [[nodiscard]] curl_slist* get() const { return list_.get(); }

 private:
  std::unique_ptr<curl_slist, FreeList> list_;
};

/// A server may repeat the address or the token of the request, which are secrets: nothing of its answer is kept.
std::size_t pass_over(char*, std::size_t, std::size_t size, void*) { return size; }

int stop_asked(void* stop, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return *static_cast<const std::atomic<bool>*>(stop) ? 1 : 0;
}

/// One transfer, with limits of its own.
class Transfer {
 public:
  Transfer(const char* protocols, const std::filesystem::path& certificate, const std::atomic<bool>& stop) {
    static const CURLcode begun = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (begun == CURLE_OK) handle_.reset(curl_easy_init());
    set(CURLOPT_NOSIGNAL, 1L);  // signals belong to the daemon
    set(CURLOPT_PROTOCOLS_STR, protocols);
    set(CURLOPT_CONNECTTIMEOUT, kConnect_s);
    set(CURLOPT_TIMEOUT, kWhole_s);
    set(CURLOPT_ERRORBUFFER, error_.data());
    set(CURLOPT_SERVER_RESPONSE_TIMEOUT, kReply_s);  // else the good-bye of a mail is waited for without an end
    set(CURLOPT_QUICK_EXIT, 1L);                     // else a name that is being looked up is waited for
    set(CURLOPT_FORBID_REUSE, 1L);
    set(CURLOPT_WRITEFUNCTION, pass_over);
    set(CURLOPT_NOPROGRESS, 0L);
    set(CURLOPT_XFERINFOFUNCTION, stop_asked);
    set(CURLOPT_XFERINFODATA, &stop);
    set(CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
    if (!certificate.empty()) {
      set(CURLOPT_CAINFO, certificate.c_str());
      set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
    }
  }

  template <class Value>
  void set(CURLoption option, Value value) {
    if (handle_ && set_ == CURLE_OK) set_ = curl_easy_setopt(handle_.get(), option, value);
  }
  [[nodiscard]] CURL* get() const { return handle_.get(); }

  /// Carries it out. Fails (device) where it does not come to its end.
  base::Status perform(const std::string& where) {
    if (!handle_ || set_ != CURLE_OK) {
      return base::fail(base::ErrorKind::internal, std::string("libcurl refuses: ") + curl_easy_strerror(set_), where);
    }
    const CURLcode ended = curl_easy_perform(handle_.get());
    if (ended == CURLE_OK) return {};
    const std::string_view own = error_.data();
    return base::fail(base::ErrorKind::device, std::string(own.empty() ? curl_easy_strerror(ended) : own), where);
  }
  [[nodiscard]] long status() const {
    long status = 0;
    curl_easy_getinfo(handle_.get(), CURLINFO_RESPONSE_CODE, &status);
    return status;
  }

 private:
  Handle handle_;
  CURLcode set_ = CURLE_OK;  ///< of the first option that it refused
  std::array<char, CURL_ERROR_SIZE> error_{};
};

/// A subject of any characters, as RFC 2047 wants it: words of at most 75 characters, none with half a character.
std::string encoded_subject(std::string_view text) {
  constexpr std::size_t kRoom = 60;
  std::string subject;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) subject += (subject.empty() ? "=?UTF-8?Q?" : "\r\n =?UTF-8?Q?") + word + "?=";
    word.clear();
  };
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool begins_character = (byte & 0xC0U) != 0x80U;
    if (begins_character && word.size() > kRoom - 12) end_word();  // four bytes take twelve
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    word += is_plain ? std::string(1, c) : fmt::format("={:02X}", byte);
  }
  end_word();
  return subject;
}

/// A bare line feed would be a byte of its line (RFC 2045, 6.7), not its end.
std::string with_mail_ends(std::string_view text) {
  std::string lines;
  for (const char c : text) lines += c == '\n' ? "\r\n" : std::string(1, c);
  return lines;
}

/// "Thu, 26 Nov 2026 14:05:00 +0000" (RFC 5322, 3.3), whatever language the system speaks.
std::string mail_date(std::time_t utc) {
  constexpr std::array<std::string_view, 7> kDays = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr std::array<std::string_view, 12> kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                                        "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  std::tm parts{};
  gmtime_r(&utc, &parts);
  return fmt::format("{}, {} {} {} {:02}:{:02}:{:02} +0000", kDays.at(static_cast<std::size_t>(parts.tm_wday)),
                     parts.tm_mday, kMonths.at(static_cast<std::size_t>(parts.tm_mon)), 1900 + parts.tm_year,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

class Mail final : public Delivery {
 public:
  Mail(MailTarget target, std::string password) : target_(std::move(target)), password_(std::move(password)) {}

  std::string way() const override { return "mail"; }
  std::string destination() const override { return fmt::format("{}", fmt::join(target_.to, ", ")); }
  base::Status send(const AlarmMessage& message, const std::atomic<bool>& stop) const override;

 private:
  [[nodiscard]] Lines head(const std::string& subject) const;

  MailTarget target_;
  std::string password_;
};

Lines Mail::head(const std::string& subject) const {
  Lines lines;
  lines.add("Date: " + mail_date(static_cast<std::time_t>(now_utc_s())));
  lines.add(fmt::format("From: Soak <{}>", target_.from));
  lines.add(fmt::format("To: {}", fmt::join(target_.to, ", ")));
  lines.add("Subject: " + encoded_subject(subject));
  lines.add(fmt::format("Message-ID: <{}@soak.invalid>", new_run_id()));
  lines.add("Auto-Submitted: auto-generated");  // RFC 3834: nobody's absence is to answer
  return lines;
}

base::Status Mail::send(const AlarmMessage& message, const std::atomic<bool>& stop) const {
  const bool tls = target_.security == MailSecurity::tls;
  const std::string where = fmt::format("{}:{}", target_.host, target_.port);
  Transfer transfer("smtp,smtps", target_.certificate, stop);
  transfer.set(CURLOPT_URL, ((tls ? "smtps://" : "smtp://") + where).c_str());
  const bool upgrades = target_.security == MailSecurity::starttls;
  transfer.set(CURLOPT_USE_SSL, static_cast<long>(upgrades ? CURLUSESSL_ALL : CURLUSESSL_NONE));
  if (!target_.user.empty()) {
    transfer.set(CURLOPT_USERNAME, target_.user.c_str());
    transfer.set(CURLOPT_PASSWORD, password_.c_str());
  }
  transfer.set(CURLOPT_MAIL_FROM, target_.from.c_str());
  Lines recipients;
  for (const std::string& address : target_.to) recipients.add(address);
  transfer.set(CURLOPT_MAIL_RCPT, recipients.get());
  transfer.set(CURLOPT_MAIL_RCPT_ALLLOWFAILS, 1L);  // a mailbox that is gone silences no other
  const Lines lines = head(message.subject);
  transfer.set(CURLOPT_HTTPHEADER, lines.get());
  const std::unique_ptr<curl_mime, FreeMime> mime(curl_mime_init(transfer.get()));
  curl_mimepart* part = curl_mime_addpart(mime.get());
  const std::string text = with_mail_ends(message.text);
  curl_mime_data(part, text.data(), text.size());
  curl_mime_type(part, "text/plain; charset=utf-8");
  curl_mime_encoder(part, "quoted-printable");
  transfer.set(CURLOPT_MIMEPOST, mime.get());
  return transfer.perform(where);
}

class Webhook final : public Delivery {
 public:
  Webhook(WebhookTarget target, std::string token) : target_(std::move(target)), token_(std::move(token)) {}

  std::string way() const override { return "webhook"; }
  std::string destination() const override {
    const std::size_t begin = target_.url.find("//") + 2;
    return host_of(target_.url.substr(begin, target_.url.find_first_of("/?#", begin) - begin));
  }
  base::Status send(const AlarmMessage& message, const std::atomic<bool>& stop) const override;

 private:
  WebhookTarget target_;  ///< its address filled in
  std::string token_;     ///< empty = none
};

base::Status Webhook::send(const AlarmMessage& message, const std::atomic<bool>& stop) const {
  const std::string body = message.document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  Transfer transfer("http,https", target_.certificate, stop);
  transfer.set(CURLOPT_URL, target_.url.c_str());
  // A token may go to this machine without TLS, so it may go to no proxy.
  if (is_loopback({destination(), 0})) transfer.set(CURLOPT_NOPROXY, "*");
  Lines lines;
  lines.add("Content-Type: application/json");
  lines.add("Expect:");  // no pause before the body
  if (!token_.empty()) lines.add("Authorization: Bearer " + token_);
  transfer.set(CURLOPT_HTTPHEADER, lines.get());
  transfer.set(CURLOPT_POSTFIELDSIZE, static_cast<long>(body.size()));
  transfer.set(CURLOPT_POSTFIELDS, body.c_str());
  if (auto done = transfer.perform(destination()); !done) return done;
  const long status = transfer.status();
  if (status >= kHttpOk && status < kHttpRedirect) return {};
  return base::fail(base::ErrorKind::device, fmt::format("the server answers {}", status), destination());
}

/// The secret of a file; none where no file is named.
base::Result<std::string> secret_of(const std::filesystem::path& file) {
  return file.empty() ? base::Result<std::string>("") : read_secret_line(file);
}

}  // namespace

base::Result<std::unique_ptr<Delivery>> mail_delivery(const MailTarget& target) {
  auto password = secret_of(target.password_file);
  if (!password) return base::forward_error(password);
  return std::make_unique<Mail>(target, *std::move(password));
}

base::Result<std::unique_ptr<Delivery>> webhook_delivery(const WebhookTarget& target) {
  auto token = secret_of(target.token_file);
  if (!token) return base::forward_error(token);
  WebhookTarget known = target;
  if (known.url.empty()) {
    auto url = read_secret_line(target.url_file);
    if (!url) return base::forward_error(url);
    const auto fits = check_webhook_url(*url, !token->empty());
    if (!fits) return base::bad_input("the address in it " + fits.error().message, target.url_file.string());
    known.url = *std::move(url);
  }
  return std::make_unique<Webhook>(std::move(known), *std::move(token));
}

std::vector<std::unique_ptr<Delivery>> deliveries_of(const AlarmConfig& config, AlarmSecrets secrets) {
  std::vector<std::unique_ptr<Delivery>> deliveries;
  if (config.mail) deliveries.push_back(std::make_unique<Mail>(*config.mail, std::move(secrets.password)));
  if (config.webhook) {
    WebhookTarget known = *config.webhook;
    known.url = std::move(secrets.url);
    deliveries.push_back(std::make_unique<Webhook>(std::move(known), std::move(secrets.token)));
  }
  return deliveries;
}

base::Result<std::vector<std::unique_ptr<Delivery>>> deliveries_of(const AlarmConfig& config) {
  std::vector<std::unique_ptr<Delivery>> deliveries;
  if (config.mail) {
    auto mail = mail_delivery(*config.mail);
    if (!mail) return base::forward_error(mail);
    deliveries.push_back(*std::move(mail));
  }
  if (config.webhook) {
    auto webhook = webhook_delivery(*config.webhook);
    if (!webhook) return base::forward_error(webhook);
    deliveries.push_back(*std::move(webhook));
  }
  return deliveries;
}

}  // namespace soak::station
