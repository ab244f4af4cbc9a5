// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

/// TLS by OpenSSL: the certificate of a station, and what it says of itself.
namespace soak::station {

/// PEM files: the certificate (with those that it was signed by, if any), and its key.
struct CertificateFiles {
  std::filesystem::path certificate;
  std::filesystem::path key;
};

/// Where soakd puts the certificate that it makes.
[[nodiscard]] CertificateFiles certificate_in(const std::filesystem::path& data_folder);

/// Makes sure of a certificate that the station signs itself: for these names and numeric addresses, 800 days long,
/// ECDSA on P-256 (RFC 5280, FIPS 186). What is there stays if it is good for all names for 30 days more and has its
/// key; else it is made anew. True where it was. Fails (internal) where files cannot be written.
[[nodiscard]] base::Result<bool> make_sure_of_certificate(const CertificateFiles& files,
                                                          const std::vector<std::string>& names);

/// SHA-256 of the certificate as browsers show it: "AB:CD:...". Refuses (bad_input) a file that is none.
[[nodiscard]] base::Result<std::string> fingerprint(const std::filesystem::path& certificate);

struct FreeTls {
  void operator()(SSL_CTX* context) const;
};
using TlsContext = std::unique_ptr<SSL_CTX, FreeTls>;

/// What a server speaks TLS with: 1.2 and 1.3, no renegotiation, no resumption, each connection for itself. Refuses
/// (bad_input) files that cannot be read or do not belong together, and a key that others than its owner and its group
/// may read.
[[nodiscard]] base::Result<TlsContext> tls_context(const CertificateFiles& files);

/// Makes a client take no other certificate than that of the file, whatever names are in it. Refuses (bad_input) a file
/// that is none.
[[nodiscard]] base::Status trust_only(SSL_CTX* client, const std::filesystem::path& certificate);

}  // namespace soak::station
