// SPDX-License-Identifier: Apache-2.0
#include "station/records/signing.h"

#include <sodium.h>

#include <algorithm>

#include <fmt/format.h>
#include <tuple>
#include <utility>
#include "base/hash.h"
#include "base/text.h"
#include "calib/deploy/signature.h"

namespace soak::station {
namespace {

/// The library asks to be initialised before anything else; only random numbers depend on it. False: there are none.
bool is_initialised() {
  static const bool initialised = sodium_init() >= 0;
  return initialised;
}

/// Public and secret key in libsodium's form: seed and public key together.
struct SodiumPair {
  SodiumPair(const SodiumPair&) = delete;
  SodiumPair& operator=(const SodiumPair&) = delete;
  explicit SodiumPair(const SecretKey& key) {
    (void)is_initialised();
    crypto_sign_seed_keypair(public_key.data(), secret_key.data(), key.seed().data());
  }
  ~SodiumPair() { wipe(secret_key); }

  PublicKey public_key{};
  std::array<std::uint8_t, crypto_sign_SECRETKEYBYTES> secret_key{};
};

static_assert(sizeof(PublicKey) == crypto_sign_PUBLICKEYBYTES);
static_assert(sizeof(SecretKey::Seed) == crypto_sign_SEEDBYTES);
static_assert(sizeof(calib::Signature) == crypto_sign_BYTES);

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

bool has_good_signature(const calib::Waiver& waiver, const calib::Reference& reference) {
  const auto text = calib::waiver_text(waiver, reference);
  const auto key = base::bytes_of_hex<std::tuple_size_v<PublicKey>>(waiver.public_key_hex);
  const auto signature = base::bytes_of_hex<std::tuple_size_v<calib::Signature>>(waiver.signature_hex);
  return text && key && signature && waiver.record_id == reference.record_id &&
         is_signed_by(*key, bytes_of(*text), *signature);
}

}  // namespace

SecretKey::SecretKey(SecretKey&& other) noexcept : seed_(other.seed_) { wipe(other.seed_); }

SecretKey::~SecretKey() { wipe(seed_); }

base::Result<SecretKey> new_secret_key() {
  if (!is_initialised()) {
    return base::fail(base::ErrorKind::internal, "the system provides no random numbers for a key", "libsodium");
  }
  SecretKey::Seed seed;
  randombytes_buf(seed.data(), seed.size());
  SecretKey key(seed);
  wipe(seed);
  return key;
}

PublicKey public_key_of(const SecretKey& key) { return SodiumPair(key).public_key; }

calib::KeyId key_id_of(const PublicKey& key) {
  const base::Sha256Digest digest = base::sha256(key);
  calib::KeyId id;
  std::copy_n(digest.begin(), id.size(), id.begin());
  return id;
}

calib::Signature sign(const SecretKey& key, std::span<const std::uint8_t> message) {
  const SodiumPair pair(key);
  calib::Signature signature;
  crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(), pair.secret_key.data());
  return signature;
}

bool is_signed_by(const PublicKey& key, std::span<const std::uint8_t> message, const calib::Signature& signature) {
  (void)is_initialised();
  return crypto_sign_verify_detached(signature.data(), message.data(), message.size(), key.data()) == 0;
}

void wipe(std::span<std::uint8_t> memory) { sodium_memzero(memory.data(), memory.size()); }

void wipe(std::string& text) { sodium_memzero(text.data(), text.size()); }

base::Result<base::Bytes> signed_file(std::span<const std::uint8_t> file, const SecretKey& key) {
  auto bytes = calib::with_empty_signature(file, key_id_of(public_key_of(key)));
  if (!bytes) return base::forward_error(bytes);
  calib::put_signature(*bytes, sign(key, calib::signed_message(*bytes)));
  return bytes;
}

bool is_file_signed_by(const PublicKey& key, std::span<const std::uint8_t> file) {
  const auto section = calib::signature_of(file);
  return section && section->key_id == key_id_of(key) &&
         is_signed_by(key, calib::signed_message(file), section->signature);
}

base::Result<calib::Waiver> signed_waiver(calib::Waiver waiver, const calib::Reference& reference,
                                          const SecretKey& key) {
  const auto text = calib::waiver_text(waiver, reference);
  if (!text) return base::forward_error(text);
  waiver.public_key_hex = base::to_hex(public_key_of(key));
  waiver.signature_hex = base::to_hex(sign(key, bytes_of(*text)));
  return waiver;
}

base::Status check_waiver(const calib::Waiver& waiver, const calib::Reference& reference) {
  if (has_good_signature(waiver, reference)) return {};
  if (waiver.signature_hex.empty()) {
    return base::corrupt(fmt::format("the waiver for {} '{}' is missing: restore the catalog from a backup, or sign a "
                                     "new waiver ('soak reference waive --certificate \"{}\"')",
                                     calib::name_of(reference.kind), reference.name, reference.certificate),
                         "waiver " + waiver.waiver_id);
  }
  return base::corrupt(fmt::format("the signature of {}'s waiver for {} '{}' does not match: the waiver or the entry "
                                   "of the register was changed after it was signed; restore the catalog from a "
                                   "backup, or sign a new waiver ('soak reference waive')",
                                   waiver.signer, calib::name_of(reference.kind), reference.name),
                       "waiver " + waiver.waiver_id);
}

std::vector<calib::Warning> waiver_warnings(const std::vector<calib::ReferenceUse>& references) {
  std::vector<calib::Warning> warnings;
  for (const auto& [reference, waiver, campaigns] : references) {
    if (!waiver || has_good_signature(*waiver, reference)) continue;
    warnings.push_back(
        {"waiver_signature",
         fmt::format("the signature of {}'s waiver for {} '{}' (certificate {}) does not match: the waiver or the data "
                     "of the reference were changed after it was signed",
                     waiver->signer, calib::name_of(reference.kind), reference.name, reference.certificate)});
  }
  return warnings;
}

}  // namespace soak::station
