// SPDX-License-Identifier: Apache-2.0
#include "station/records/waiver.h"

#include <fmt/format.h>

#include <tuple>
#include <utility>

#include "base/hash.h"
#include "base/hex.h"
#include "calib/deploy/signature.h"

namespace soak::station {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

bool is_good(const calib::Waiver& waiver, const calib::Reference& reference) {
  const auto text = calib::waiver_text(waiver, reference);
  const auto key = base::bytes_of_hex<std::tuple_size_v<PublicKey>>(waiver.public_key_hex);
  const auto signature = base::bytes_of_hex<std::tuple_size_v<calib::Signature>>(waiver.signature_hex);
  return text && key && signature && waiver.record_id == reference.record_id &&
         is_signed_by(*key, bytes_of(*text), *signature);
}

}  // namespace

base::Result<calib::Waiver> signed_waiver(calib::Waiver waiver, const calib::Reference& reference,
                                          const SecretKey& key) {
  const auto text = calib::waiver_text(waiver, reference);
  if (!text) return base::forward_error(text);
  waiver.public_key_hex = base::to_hex(public_key_of(key));
  waiver.signature_hex = base::to_hex(sign(key, bytes_of(*text)));
  return waiver;
}

base::Status check_waiver(const calib::Waiver& waiver, const calib::Reference& reference) {
  if (is_good(waiver, reference)) return {};
  if (waiver.signature_hex.empty()) {
    return base::corrupt(
        fmt::format("the waiver by which {} '{}' was used is gone; restore the catalog from a copy, or sign a new "
                    "waiver ('soak reference waive --certificate \"{}\"')",
                    calib::name_of(reference.kind), reference.name, reference.certificate),
        "waiver " + waiver.waiver_id);
  }
  return base::corrupt(
      fmt::format("the waiver of {} for {} '{}' does not carry a good signature: it, or the entry of the register, was "
                  "changed after it was signed; restore the catalog from a copy, or sign a new waiver ('soak reference "
                  "waive')",
                  waiver.signer, calib::name_of(reference.kind), reference.name),
      "waiver " + waiver.waiver_id);
}

std::vector<calib::Warning> waiver_warnings(const std::vector<calib::ReferenceUse>& references) {
  std::vector<calib::Warning> warnings;
  for (const auto& [reference, waiver] : references) {
    if (!waiver || is_good(*waiver, reference)) continue;
    warnings.push_back(
        {"waiver_signature",
         fmt::format("the waiver of {} for {} '{}' (certificate {}) does not carry a good signature: it, "
                     "or what is said of the reference, was changed after it was signed",
                     waiver->signer, calib::name_of(reference.kind), reference.name, reference.certificate)});
  }
  return warnings;
}

}  // namespace soak::station
