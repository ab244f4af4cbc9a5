// SPDX-License-Identifier: Apache-2.0
#include "station/records/signing.h"

#include <sodium.h>

#include <algorithm>

#include "base/hash.h"

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

}  // namespace

SecretKey::SecretKey(SecretKey&& other) noexcept : seed_(other.seed_) { wipe(other.seed_); }

SecretKey::~SecretKey() { wipe(seed_); }

base::Result<SecretKey> new_secret_key() {
  if (!is_initialised()) {
    return base::fail(base::ErrorKind::internal, "the system gives no random numbers for a key", "libsodium");
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

}  // namespace soak::station
