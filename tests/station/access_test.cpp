// SPDX-License-Identifier: Apache-2.0
// Accounts, passwords, sessions and limits of log-ins: what does not need a network.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "station/access/accounts.h"
#include "station/access/gate.h"
#include "station/access/login_limits.h"
#include "station/access/secrets.h"
#include "station/access/sessions.h"
#include "station/http/access_api.h"
#include "station/http/tls.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using namespace std::chrono_literals;

class AccountsFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "soak-accounts-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  void add(const std::string& name, Role role, const std::string& password) const {
    const auto added = change_accounts(folder, [&](Accounts& accounts) -> base::Status {
      accounts.push_back({name, role, password, 1790000000.0, {}});
      return {};
    });
    ASSERT_TRUE(added) << added.error().message;
  }
  void write(const std::string& text, mode_t mode = 0600) const {
    std::ofstream(accounts_file(folder)) << text;
    ASSERT_EQ(::chmod(accounts_file(folder).c_str(), mode), 0);
  }

  std::filesystem::path folder;
};

// A disk that does not answer holds up whoever reads the file, and nobody else.
TEST_F(AccountsFile, ThatDoesNotAnswerHoldsUpOneCallerOnly) {
  add("eva", Role::operating, "kept");
  AccountBook book(folder);
  std::filesystem::remove(accounts_file(folder));
  ASSERT_EQ(::mkfifo(accounts_file(folder).c_str(), 0600), 0);
  auto held_up = std::async(std::launch::async, [&] { return book.now(); });
  int writer = -1;
  while ((writer = ::open(accounts_file(folder).c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC)) < 0) {
    std::this_thread::sleep_for(1ms);  // until it reads
  }
  auto other = std::async(std::launch::async, [&] { return book.now(); });
  const bool has_answered = other.wait_for(20s) == std::future_status::ready;
  ::close(writer);
  EXPECT_TRUE(has_answered);
  EXPECT_EQ(other.get()->size(), 1U);
  EXPECT_EQ(held_up.get()->size(), 1U);
}

TEST_F(AccountsFile, LogInsAreNotedWithAccountAndAddressAndRefusalsWithinARation) {
  add("eva", Role::operating, *kept_of_password("correct horse"));
  std::vector<std::string> notes;
  Gate gate(folder, [&](const std::string& kind, const std::string& account, const std::string& text) {
    notes.push_back(kind + "|" + account + "|" + text);
  });
  const auto entry = gate.log_in("eva", "correct horse", "10.0.0.7");
  ASSERT_TRUE(entry) << entry.error().message;
  gate.log_out(entry->session, "10.0.0.7");
  gate.log_out("no session", "10.0.0.7");
  EXPECT_FALSE(gate.log_in("eva", "wrong horse", "10.0.0.7"));
  EXPECT_FALSE(gate.log_in("correct horse", "eva", "10.0.0.7"));
  EXPECT_EQ(notes, (std::vector<std::string>{"logged_in|eva|logged in from 10.0.0.7, operator",
                                             "logged_out|eva|logged out from 10.0.0.7",
                                             "login_refused|eva|refused from 10.0.0.7: wrong password",
                                             "login_refused||refused from 10.0.0.7: no such account"}));
  notes.clear();
  for (int i = 0; i < 1000; ++i) {  // after ten the tries of the address are used up: these cost no password
    EXPECT_FALSE(gate.log_in("nobody", "wrong horse", "10.0.0.8"));
  }
  EXPECT_LT(notes.size(), 80U);
  EXPECT_TRUE(notes.back().starts_with("login_limited||refused from 10.0.0.8: too many tries")) << notes.back();
}

// The argon2id vector with two passes over 64 MiB of the reference implementation, phc-winner-argon2: src/test.c.
TEST(Password, IsHeldAgainstAHashOfTheReferenceImplementation) {
  const std::string kept = "$argon2id$v=19$m=65536,t=2,p=1$c29tZXNhbHQ$CTFhFdXPJO1aFaMaO6Mm5c8y7cJHAph8ArZWb2GRPPc";
  EXPECT_TRUE(is_password(kept, "password"));
  EXPECT_FALSE(is_password(kept, "Password"));
  EXPECT_FALSE(is_password("", "password"));
  EXPECT_FALSE(is_password("no hash at all", "password"));
}

TEST(Password, IsKeptAsArgon2idWithASaltOfItsOwn) {
  const auto first = kept_of_password("correct horse");
  const auto second = kept_of_password("correct horse");
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(first->starts_with("$argon2id$v=19$m=65536,t=2,p=1$")) << *first;
  EXPECT_NE(*first, *second);
  EXPECT_TRUE(is_password(*first, "correct horse"));
  EXPECT_FALSE(is_password(*first, "correct horsf"));
}

TEST(Password, ThatIsShortOrLongOrNotOneLineIsRefused) {
  EXPECT_TRUE(check_password("ten bytes!"));
  EXPECT_TRUE(check_password("Fünf Äpfel, größer als 10 €"));
  for (const std::string& bad : {std::string("nine byte"), std::string(201, 'x'), std::string("with a\nnew line"),
                                 std::string("with a \0 zero", 13)}) {
    EXPECT_FALSE(check_password(bad));
  }
}

TEST(AccountName, ThatCouldDoHarmIsRefused) {
  for (const char* good : {"eva", "e", "eva.b-2_c", "a2345678901234567890123456789012"}) {
    EXPECT_TRUE(check_account_name(good)) << good;
  }
  for (const char* bad : {"", "Eva", "2eva", ".eva", "-eva", "../eva", "eva b", "eva\n", "<b>eva</b>", "evä",
                          "eva\x1b[2J", "a23456789012345678901234567890123", "eva'; drop table event", "__proto__"}) {
    EXPECT_FALSE(check_account_name(bad)) << bad;
  }
}

TEST_F(AccountsFile, IsForItsOwnerAloneAndIsReadBackAsItWasWritten) {
  ::umask(0);
  add("eva", Role::engineer, "kept");
  ::umask(022);
  struct stat status{};
  ASSERT_EQ(::stat(accounts_file(folder).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  const auto accounts = read_accounts(folder);
  ASSERT_TRUE(accounts) << accounts.error().message;
  ASSERT_EQ(accounts->size(), 1U);
  EXPECT_EQ(accounts->front().name, "eva");
  EXPECT_EQ(accounts->front().role, Role::engineer);
  EXPECT_EQ(accounts->front().password, "kept");
}

TEST_F(AccountsFile, ThatIsNotThereHasNoAccounts) {
  const auto accounts = read_accounts(folder);
  ASSERT_TRUE(accounts);
  EXPECT_TRUE(accounts->empty());
}

TEST_F(AccountsFile, ThatOthersCanReadIsRefused) {
  write(R"({"format": 1, "accounts": []})", 0640);
  const auto accounts = read_accounts(folder);
  ASSERT_FALSE(accounts);
  EXPECT_EQ(accounts.error().kind, base::ErrorKind::bad_input);
  EXPECT_NE(accounts.error().message.find("chmod 600"), std::string::npos);
}

TEST_F(AccountsFile, ThatIsDamagedOrHoldsAHostileNameIsRefusedAsAWhole) {
  const std::string account = R"({"name": "NAME", "role": "ROLE", "password": "x", "made_utc_s": 1.0, "tokens": []})";
  const auto with = [&](std::string name, std::string role) {
    std::string text = account;
    text.replace(text.find("NAME"), 4, name).replace(text.find("ROLE"), 4, role);
    return R"({"format": 1, "accounts": [)" + text + "]}";
  };
  write(with("eva", "viewer"));
  EXPECT_TRUE(read_accounts(folder));
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string(R"({"format": 2, "accounts": []})"),
        with("<script>", "viewer"), with("../x", "viewer"), with("eva", "root"),
        R"({"format": 1, "accounts": [)" + account + "]}"}) {
    write(text);
    const auto accounts = read_accounts(folder);
    ASSERT_FALSE(accounts) << text;
    EXPECT_EQ(accounts.error().kind, base::ErrorKind::corrupt) << text;
  }
}

TEST_F(AccountsFile, IsNotChangedWhereTheChangeIsRefused) {
  add("eva", Role::viewer, "kept");
  const auto refused = change_accounts(folder, [](Accounts& accounts) -> base::Status {
    accounts.clear();
    return base::bad_input("no");
  });
  EXPECT_FALSE(refused);
  EXPECT_EQ(read_accounts(folder)->size(), 1U);
}

TEST_F(AccountsFile, ChangesAreSeenByTheGateAtOnce) {
  Gate gate(folder);
  EXPECT_FALSE(gate.log_in("eva", "correct horse", "127.0.0.1"));
  add("eva", Role::viewer, *kept_of_password("correct horse"));
  const auto entry = gate.log_in("eva", "correct horse", "127.0.0.1");
  ASSERT_TRUE(entry) << entry.error().message;
  EXPECT_TRUE(gate.caller({entry->session, ""}));
  ASSERT_TRUE(change_accounts(folder, [](Accounts& accounts) -> base::Status {
    accounts.clear();
    return {};
  }));
  EXPECT_FALSE(gate.caller({entry->session, ""}));
}

// A disk that was unmounted shall not keep anybody from an abort.
TEST_F(AccountsFile, ThatIsLostOrDamagedLeavesTheAccountsAsTheyWere) {
  add("eva", Role::operating, *kept_of_password("correct horse"));
  Gate gate(folder);
  const auto entry = gate.log_in("eva", "correct horse", "127.0.0.1");
  ASSERT_TRUE(entry) << entry.error().message;
  write("{");
  EXPECT_TRUE(gate.caller({entry->session, ""}));
  std::filesystem::remove(accounts_file(folder));
  EXPECT_TRUE(gate.caller({entry->session, ""}));
}

// A station that is out of descriptors for a moment, just when an account is removed.
TEST_F(AccountsFile, ARevocationThatCannotBeReadAtFirstIsNotLost) {
  add("eva", Role::operating, *kept_of_password("correct horse"));
  Gate gate(folder);
  const auto entry = gate.log_in("eva", "correct horse", "127.0.0.1");
  ASSERT_TRUE(entry) << entry.error().message;
  ASSERT_TRUE(change_accounts(folder, [](Accounts& accounts) -> base::Status {
    accounts.clear();
    return {};
  }));
  // The sanitizer needs a descriptor of its own where it meets a class for the first time.
  log_line("the log is open before there are no descriptors");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const bool known_meanwhile = gate.caller({entry->session, ""}).has_value();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_TRUE(known_meanwhile);
  EXPECT_FALSE(gate.caller({entry->session, ""}));
}

TEST_F(AccountsFile, ThatCannotBeReadIsReadAgainAndLoggedOnce) {
  add("eva", Role::viewer, "kept");
  AccountBook book(folder);
  ASSERT_EQ(book.now()->size(), 1U);
  std::filesystem::remove(accounts_file(folder));
  std::filesystem::create_directory(accounts_file(folder));
  std::filesystem::permissions(accounts_file(folder), std::filesystem::perms::owner_all);
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(book.now()->size(), 1U);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(log, '\n'), 1) << log;
  std::filesystem::remove(accounts_file(folder));
  write(R"({"format": 1, "accounts": []})");
  EXPECT_TRUE(book.now()->empty());
}

TEST_F(AccountsFile, StrangersWhoTakeAllPlacesKeepNobodyOutWhoSitsAtTheMachine) {
  add("eva", Role::viewer, *kept_of_password("correct horse"));
  Gate gate(folder);
  std::atomic<bool> enough = false;
  std::atomic<int> refused = 0;
  std::vector<std::jthread> strangers;
  for (int i = 0; i < 6; ++i) {
    strangers.emplace_back([&, i] {
      for (int n = 0; !enough && n < 250; ++n) {
        const std::string address = "10.0." + std::to_string(i) + "." + std::to_string(n);
        const auto entry = gate.log_in("n" + std::to_string(i) + "-" + std::to_string(n), "wrong horse", address);
        if (entry.error().where == kTooManyTries) {
          ++refused;
          std::this_thread::sleep_for(5ms);
        }
      }
    });
  }
  while (refused == 0) std::this_thread::sleep_for(1ms);
  for (int i = 0; i < 3; ++i) {
    const auto entry = gate.log_in("eva", "correct horse", "127.0.0.1");
    EXPECT_TRUE(entry) << entry.error().message;
  }
  enough = true;
}

TEST_F(AccountsFile, ATokenMayNoMoreThanItsAccount) {
  const auto set = [&](Role account, Role token) {
    const auto changed = change_accounts(folder, [&](Accounts& accounts) -> base::Status {
      accounts = {{"eva", account, "x", 0.0, {{"nightly", token, kept_of_secret("secret"), 0.0}}}};
      return {};
    });
    ASSERT_TRUE(changed);
  };
  Gate gate(folder);
  set(Role::engineer, Role::viewer);
  EXPECT_EQ(gate.caller({"", "secret"})->role, Role::viewer);
  set(Role::operating, Role::engineer);
  EXPECT_EQ(gate.caller({"", "secret"})->role, Role::operating);
  EXPECT_FALSE(gate.caller({"", "Secret"}));
  EXPECT_FALSE(gate.caller({"secret", ""}));
  EXPECT_FALSE(gate.caller({"", kept_of_secret("secret")}));
}

TEST_F(AccountsFile, AWrongNameAndAWrongPasswordAreRefusedAlike) {
  add("eva", Role::viewer, *kept_of_password("correct horse"));
  Gate gate(folder);
  const auto password = gate.log_in("eva", "wrong horse", "127.0.0.1");
  const auto name = gate.log_in("adam", "wrong horse", "127.0.0.1");
  ASSERT_FALSE(password || name);
  EXPECT_EQ(password.error().message, name.error().message);
  EXPECT_EQ(password.error().where, name.error().where);
}

using StationCertificate = AccountsFile;

// The clock was ahead when it was made.
TEST_F(StationCertificate, ThatIsNotValidYetIsMadeAnew) {
  const CertificateFiles files = certificate_in(folder);
  ASSERT_TRUE(make_sure_of_certificate(files, {"lab-pc"}).value_or(false));
  ASSERT_FALSE(make_sure_of_certificate(files, {"lab-pc"}).value_or(true));
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  const std::unique_ptr<X509, void (*)(X509*)> certificate(
      PEM_read_X509(File(std::fopen(files.certificate.c_str(), "r"), std::fclose).get(), nullptr, nullptr, nullptr),
      X509_free);
  const std::unique_ptr<EVP_PKEY, void (*)(EVP_PKEY*)> key(
      PEM_read_PrivateKey(File(std::fopen(files.key.c_str(), "r"), std::fclose).get(), nullptr, nullptr, nullptr),
      EVP_PKEY_free);
  ASSERT_TRUE(certificate && key);
  ASSERT_NE(X509_gmtime_adj(X509_getm_notBefore(certificate.get()), 3600), nullptr);
  ASSERT_NE(X509_sign(certificate.get(), key.get(), EVP_sha256()), 0);
  ASSERT_EQ(PEM_write_X509(File(std::fopen(files.certificate.c_str(), "w"), std::fclose).get(), certificate.get()), 1);
  EXPECT_TRUE(make_sure_of_certificate(files, {"lab-pc"}).value_or(false));
  EXPECT_FALSE(make_sure_of_certificate(files, {"lab-pc"}).value_or(true));
}

class OpenSession : public ::testing::Test {
 protected:
  Accounts accounts = {{"eva", Role::operating, "kept", 0.0, {}}};
  Sessions sessions;
  Sessions::Time begin = Sessions::Time() + 1000h;
  std::string secret = *sessions.open(accounts[0], begin);

  bool holds(Sessions::Time at) { return sessions.account_of(secret, accounts, at) == &accounts[0]; }
};

TEST_F(OpenSession, HoldsForItsSecretAlone) {
  EXPECT_TRUE(holds(begin));
  EXPECT_EQ(secret.size(), 64U);
  std::string forged = secret;
  forged.back() = forged.back() == '0' ? '1' : '0';
  for (const std::string& other : {forged, std::string(), kept_of_secret(secret), std::string("eva")}) {
    EXPECT_EQ(sessions.account_of(other, accounts, begin), nullptr) << other;
  }
  EXPECT_NE(*sessions.open(accounts[0], begin), secret);
}

TEST_F(OpenSession, EndsAfterAnHourOfSilence) {
  EXPECT_TRUE(holds(begin + 59min));
  EXPECT_TRUE(holds(begin + 118min));
  EXPECT_FALSE(holds(begin + 118min + 61min));
  EXPECT_FALSE(holds(begin + 119min)) << "it has come back";
}

TEST_F(OpenSession, EndsAfterAWeekHoweverMuchItIsUsed) {
  for (auto at = begin; at <= begin + 168h; at += 30min) ASSERT_TRUE(holds(at));
  EXPECT_FALSE(holds(begin + 168h + 1min));
}

TEST_F(OpenSession, EndsWithLogOutRemovalAndANewPassword) {
  const std::string other = *sessions.open(accounts[0], begin);
  sessions.close(secret);
  EXPECT_FALSE(holds(begin));
  EXPECT_NE(sessions.account_of(other, accounts, begin), nullptr);
  accounts[0].password = "another";
  EXPECT_EQ(sessions.account_of(other, accounts, begin), nullptr);
  secret = *sessions.open(accounts[0], begin);
  EXPECT_EQ(sessions.account_of(secret, Accounts(), begin), nullptr);
}

TEST_F(OpenSession, OfTooManyOfAnAccountTheLongestSilentOneEnds) {
  std::vector<std::string> others;
  for (int i = 1; i < 32; ++i) others.push_back(*sessions.open(accounts[0], begin + std::chrono::minutes(i)));
  ASSERT_TRUE(holds(begin + 40min));
  (void)sessions.open(accounts[0], begin + 41min);
  EXPECT_TRUE(holds(begin + 41min));
  EXPECT_EQ(sessions.account_of(others[0], accounts, begin + 41min), nullptr);
  EXPECT_NE(sessions.account_of(others[1], accounts, begin + 41min), nullptr);
}

class Tries : public ::testing::Test {
 protected:
  LoginLimits limits;
  LoginLimits::Time begin = LoginLimits::Time() + 1000h;

  bool may_try(const std::string& address, const std::string& account, LoginLimits::Time at) {
    return !limits.take_try(address, account, at);
  }
  /// From many addresses, none of which tries often.
  void attack(const std::string& account, LoginLimits::Time at) {
    for (int i = 0; i < 400; ++i)
      (void)may_try("10.9." + std::to_string(i / 200) + "." + std::to_string(i % 200), account, at);
  }
};

TEST_F(Tries, OfAnAddressAreTenAndOneMoreEveryHalfMinute) {
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(may_try("10.0.0.7", "eva" + std::to_string(i), begin));
  EXPECT_FALSE(may_try("10.0.0.7", "adam", begin));
  const auto wait_s = limits.take_try("10.0.0.7", "adam", begin + 10s);
  ASSERT_TRUE(wait_s);
  EXPECT_NEAR(*wait_s, 20.0, 1e-6);
  EXPECT_TRUE(may_try("10.0.0.7", "adam", begin + 31s));
  EXPECT_FALSE(may_try("10.0.0.7", "adam", begin + 31s));
  EXPECT_TRUE(may_try("10.0.0.8", "adam", begin + 31s));
}

TEST_F(Tries, OfAnAccountFromManyAddressesAreTwentyAtOnce) {
  int let_in = 0;
  for (int i = 0; i < 200; ++i) let_in += may_try("10.0.1." + std::to_string(i), "eva", begin) ? 1 : 0;
  EXPECT_EQ(let_in, 20);
  EXPECT_TRUE(may_try("10.0.2.1", "adam", begin)) << "another account";
}

TEST_F(Tries, OfStrangersKeepNobodyOutWhoHasBeenHereOrSitsAtTheMachine) {
  ASSERT_TRUE(may_try("10.0.0.7", "eva", begin));
  limits.was_right("10.0.0.7", "eva", begin);
  for (int hour = 0; hour < 24; ++hour) {
    const auto at = begin + std::chrono::hours(hour);
    attack("eva", at);
    EXPECT_TRUE(may_try("10.0.0.7", "eva", at));
    EXPECT_TRUE(may_try("127.0.0.1", "eva", at));
    EXPECT_TRUE(may_try("::1", "eva", at));
  }
}

TEST_F(Tries, ThatAreRightCostNothing) {
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(may_try("10.0.0.7", "eva", begin)) << i;
    limits.was_right("10.0.0.7", "eva", begin);
  }
}

TEST_F(Tries, ThatCameToNothingCostNothingAndMakeNobodyKnown) {
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(may_try("10.0.0.7", "eva", begin)) << i;
    limits.give_back("10.0.0.7", "eva", begin);
  }
  EXPECT_FALSE(limits.knows("10.0.0.7", "eva"));
  limits.was_right("10.0.0.7", "eva", begin);
  EXPECT_TRUE(limits.knows("10.0.0.7", "eva"));
  EXPECT_FALSE(limits.knows("10.0.0.7", "adam"));
  EXPECT_TRUE(limits.knows("127.0.0.1", "adam"));
}

TEST_F(Tries, OfANetworkOfIpv6CountTogether) {
  int let_in = 0;
  for (int i = 0; i < 100; ++i)
    let_in += may_try("2001:db8:1:2::" + std::to_string(i), "e" + std::to_string(i), begin) ? 1 : 0;
  EXPECT_EQ(let_in, 10);
  EXPECT_TRUE(may_try("2001:db8:1:3::1", "eva", begin));
}

TEST_F(Tries, OfAnAddressAreNotForgottenForThousandsOfOthers) {
  for (int i = 0; i < 11; ++i) (void)may_try("10.0.0.7", "adam" + std::to_string(i), begin);
  for (int i = 0; i < 5000; ++i) {
    (void)may_try(
        "10." + std::to_string(10 + i / 40000) + "." + std::to_string(i / 200) + "." + std::to_string(i % 200),
        "name" + std::to_string(i), begin + 1s);
  }
  EXPECT_FALSE(may_try("10.0.0.7", "eva", begin + 2s));
}

TEST(RoleOfACommand, IsEngineerWhereNothingElseIsKnown) {
  const auto role = [](const char* name, const char* body) {
    return role_of_command(name, nlohmann::json::parse(body));
  };
  for (const char* name : {"campaign/start", "campaign/abort", "campaign/confirm", "unit/add"}) {
    EXPECT_EQ(role(name, "{}"), Role::operating) << name;
  }
  for (const char* kind : {"fit", "fit_all", "verify", "verify_all", "report", "gap_find", "gap_show"}) {
    EXPECT_EQ(role_of_command("jobs", {{"kind", kind}}), Role::operating) << kind;
  }
  for (const char* kind : {"release", "release_all", "export", "gap_accept"}) {
    EXPECT_EQ(role_of_command("jobs", {{"kind", kind}}), Role::engineer) << kind;
  }
  EXPECT_EQ(role("jobs", R"({"kind": "export"})"), Role::engineer);
  EXPECT_EQ(role("jobs", R"({"kind": ["fit"]})"), Role::engineer);
  EXPECT_EQ(role("jobs", "{}"), Role::engineer);
  EXPECT_EQ(role("run/void", "{}"), Role::engineer);
  EXPECT_EQ(role("something/new", "{}"), Role::engineer);
}

}  // namespace
}  // namespace soak::station
