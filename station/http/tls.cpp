// SPDX-License-Identifier: Apache-2.0
#include "station/http/tls.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "base/file_descriptor.h"
#include "db/durable.h"
#include "station/http/address.h"

namespace soak::station {
namespace {

template <auto function>
struct Free {
  template <class T>
  void operator()(T* object) const {
    function(object);
  }
};
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>>;
using File = std::unique_ptr<std::FILE, Free<std::fclose>>;

constexpr long kDay_s = 24L * 3600;
constexpr long kValid_s = 800 * kDay_s;  // Apple's devices refuse more than 825 days
constexpr long kRenewedBefore_s = 30 * kDay_s;
constexpr mode_t kOwnerOnly = 0600;
constexpr mode_t kEveryone = 0644;

std::string reason_of_library() {
  const char* reason = ERR_reason_error_string(ERR_peek_last_error());
  return reason == nullptr ? "unknown reason" : reason;
}

Certificate read_certificate(const std::filesystem::path& path) {
  const File file(std::fopen(path.c_str(), "re"));
  return Certificate(file ? PEM_read_X509(file.get(), nullptr, nullptr, nullptr) : nullptr);
}

Key read_key(const std::filesystem::path& path) {
  const File file(std::fopen(path.c_str(), "re"));
  return Key(file ? PEM_read_PrivateKey(file.get(), nullptr, nullptr, nullptr) : nullptr);
}

bool has_name(X509* certificate, const std::string& name) {
  if (is_numeric_address(name)) return X509_check_ip_asc(certificate, name.c_str(), 0) == 1;
  return X509_check_host(certificate, name.c_str(), name.size(), 0, nullptr) == 1;
}

bool is_good_for(const CertificateFiles& files, const std::vector<std::string>& names) {
  ERR_clear_error();
  const Certificate certificate = read_certificate(files.certificate);
  const Key key = read_key(files.key);
  if (!certificate || !key || X509_check_private_key(certificate.get(), key.get()) != 1) return false;
  std::time_t now = std::time(nullptr);
  std::time_t soon = now + kRenewedBefore_s;
  if (X509_cmp_time(X509_get0_notBefore(certificate.get()), &now) >= 0) return false;
  if (X509_cmp_time(X509_get0_notAfter(certificate.get()), &soon) <= 0) return false;
  for (const std::string& name : names) {
    if (!has_name(certificate.get(), name)) return false;
  }
  return true;
}

/// "DNS:lab-pc,IP:10.0.0.7"; a name that a configuration took in has no comma.
std::string alternative_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += fmt::format("{}{}:{}", text.empty() ? "" : ",", is_numeric_address(name) ? "IP" : "DNS", name);
  }
  return text;
}

bool add_extension(X509* certificate, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

/// Null where the library cannot.
Certificate make_certificate(EVP_PKEY* key, const std::vector<std::string>& names) {
  Certificate certificate(X509_new());
  std::array<unsigned char, 16> number{};
  if (!certificate || RAND_bytes(number.data(), number.size()) != 1) return nullptr;
  number[0] &= 0x7FU;  // a positive number: RFC 5280, 4.1.2.2
  const std::unique_ptr<BIGNUM, Free<BN_free>> serial(BN_bin2bn(number.data(), number.size(), nullptr));
  X509_NAME* subject = X509_get_subject_name(certificate.get());
  const auto* common_name = reinterpret_cast<const unsigned char*>("Soak station");
  const bool made = X509_set_version(certificate.get(), X509_VERSION_3) == 1 && serial &&
                    BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(certificate.get())) != nullptr &&
                    X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -kDay_s) != nullptr &&
                    X509_gmtime_adj(X509_getm_notAfter(certificate.get()), kValid_s) != nullptr &&
                    X509_set_pubkey(certificate.get(), key) == 1 &&
                    X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC, common_name, -1, -1, 0) == 1 &&
                    X509_set_issuer_name(certificate.get(), subject) == 1 &&
                    add_extension(certificate.get(), NID_basic_constraints, "critical,CA:FALSE") &&
                    add_extension(certificate.get(), NID_key_usage, "critical,digitalSignature") &&
                    add_extension(certificate.get(), NID_ext_key_usage, "serverAuth") &&
                    add_extension(certificate.get(), NID_subject_alt_name, alternative_names(names)) &&
                    X509_sign(certificate.get(), key, EVP_sha256()) != 0;
  return made ? std::move(certificate) : nullptr;
}

std::filesystem::path temporary_of(const std::filesystem::path& path) { return path.string() + ".tmp"; }

/// Writes what `path` shall hold beside it.
template <class Write>
base::Status write_temporary(const std::filesystem::path& path, mode_t mode, Write write) {
  const std::filesystem::path temporary = temporary_of(path);
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  bool written = false;
  {
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    const File file(descriptor < 0 ? nullptr : ::fdopen(descriptor, "w"));
    written = file && write(file.get()) == 1 && std::fflush(file.get()) == 0;
  }
  if (written) return {};
  std::filesystem::remove(temporary, ignored);
  return base::fail(base::ErrorKind::internal, "cannot write the file", path.string());
}

base::Status check_private(const std::filesystem::path& key) {
  struct stat status{};
  if (::stat(key.c_str(), &status) != 0 || (status.st_mode & (S_IRWXO | S_IWGRP)) == 0) return {};
  return base::bad_input(
      fmt::format("others may read or write this key (mode {:04o}): 'chmod 600' it", status.st_mode & 07777U),
      key.string());
}

/// Called in place of the library's own check of a client.
int is_the_trusted_one(X509_STORE_CTX* store, void* trusted) {
  return X509_cmp(X509_STORE_CTX_get0_cert(store), static_cast<X509*>(trusted)) == 0 ? 1 : 0;
}

}  // namespace

void FreeTls::operator()(SSL_CTX* context) const { SSL_CTX_free(context); }

CertificateFiles certificate_in(const std::filesystem::path& data_folder) {
  return {data_folder / "soakd.crt", data_folder / "soakd.key"};
}

base::Result<bool> make_sure_of_certificate(const CertificateFiles& files, const std::vector<std::string>& names) {
  if (is_good_for(files, names)) return false;
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate = key ? make_certificate(key.get(), names) : nullptr;
  if (!certificate) {
    return base::fail(base::ErrorKind::internal, "cannot make a certificate: " + reason_of_library(),
                      files.certificate.string());
  }
  const auto write_key = [&](std::FILE* file) {
    return PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  };
  const auto write_certificate = [&](std::FILE* file) { return PEM_write_X509(file, certificate.get()); };
  // Both are written before either is replaced: on a full disk the pair before stays whole.
  if (auto written = write_temporary(files.key, kOwnerOnly, write_key); !written) return base::forward_error(written);
  auto made = write_temporary(files.certificate, kEveryone, write_certificate);
  if (made) made = db::rename_durably(temporary_of(files.key), files.key);
  if (made) made = db::rename_durably(temporary_of(files.certificate), files.certificate);
  if (made) return true;
  std::error_code ignored;
  for (const auto& path : {files.key, files.certificate}) std::filesystem::remove(temporary_of(path), ignored);
  return base::forward_error(made);
}

base::Result<std::string> fingerprint(const std::filesystem::path& path) {
  const Certificate certificate = read_certificate(path);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (!certificate || X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size) != 1) {
    return base::bad_input("is not a certificate in PEM form", path.string());
  }
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{}{:02X}", i == 0 ? "" : ":", digest[i]);
  return text;
}

base::Result<TlsContext> tls_context(const CertificateFiles& files) {
  if (auto is_private = check_private(files.key); !is_private) return base::forward_error(is_private);
  ERR_clear_error();
  TlsContext context(SSL_CTX_new(TLS_server_method()));
  const auto refuse = [](const std::string& what, const std::filesystem::path& where) {
    return base::bad_input(what + ": " + reason_of_library(), where.string());
  };
  if (!context) return refuse("cannot speak TLS", files.certificate);
  if (SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1) {
    return refuse("the certificate cannot be read, it must be PEM", files.certificate);
  }
  if (SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return refuse("the key cannot be read, or is not that of the certificate", files.key);
  }
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_TICKET | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_num_tickets(context.get(), 0);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  return context;
}

base::Status trust_only(SSL_CTX* client, const std::filesystem::path& path) {
  const Certificate certificate = read_certificate(path);
  if (!certificate) return base::bad_input("is not a certificate in PEM form", path.string());
  X509* trusted = certificate.get();
  // The store keeps it for as long as the context lives.
  if (X509_STORE_add_cert(SSL_CTX_get_cert_store(client), trusted) != 1) {
    return base::fail(base::ErrorKind::internal, "cannot be kept: " + reason_of_library(), path.string());
  }
  SSL_CTX_set_cert_verify_callback(client, is_the_trusted_one, trusted);
  SSL_CTX_set_verify(client, SSL_VERIFY_PEER, nullptr);
  return {};
}

}  // namespace soak::station
