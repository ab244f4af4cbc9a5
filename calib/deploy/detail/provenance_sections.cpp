// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/hash.h"
#include "base/text.h"
#include "calib/deploy/detail/sections.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib::file {
namespace {

// ---- the calibration as a whole ----

constexpr std::uint32_t kSimulated = 1;
constexpr std::uint32_t kGravityAssumed = 2;
constexpr std::uint32_t kUnreleased = 4;

base::Status check_provenance(const Calibration& calibration) {
  if (calibration.unit.empty()) return base::bad_input("the calibration names no unit", "unit");
  if (auto status = check_text(calibration.unit, "serial number"); !status) return status;
  if (auto status = check_text(calibration.unit_type, "unit type"); !status) return status;
  if (!std::isfinite(calibration.created_utc_s) || !std::isfinite(calibration.gravity_mps2)) {
    return base::bad_input("creation time and gravity must be finite numbers", "created_utc_s, gravity_mps2");
  }
  if (calibration.run_hashes.size() > SOAK_MAX_RUNS) {
    return base::bad_input("the file carries the hashes of at most " + std::to_string(SOAK_MAX_RUNS) + " runs",
                           "run_hashes");
  }
  return {};
}

// ---- references ----

constexpr std::uint8_t kHasCorrection = 1;
constexpr std::uint8_t kHasWaiver = 2;

using UuidBytes = std::array<std::uint8_t, 16>;

std::optional<UuidBytes> bytes_of_uuid(std::string text) {
  if (text.size() != 36 || text[8] != '-' || text[13] != '-' || text[18] != '-' || text[23] != '-') return std::nullopt;
  std::erase(text, '-');
  return base::bytes_of_hex<16>(text);
}

std::string uuid_text(std::span<const std::uint8_t> bytes) {
  std::string text = base::to_hex(bytes);
  for (const std::size_t at : {8U, 13U, 18U, 23U}) text.insert(at, 1, '-');
  return text;
}

bool has_empty_text(const ReferenceUse& use) {
  return use.reference.name.empty() || use.reference.certificate.empty() ||
         (use.waiver && (use.waiver->reason.empty() || use.waiver->signer.empty()));
}

bool has_sound_numbers(const Reference& reference) {
  return std::isfinite(reference.standard_uncertainty) && reference.standard_uncertainty >= 0.0 &&
         std::isfinite(reference.correction.value_or(0.0)) && std::isfinite(reference.issued_utc_s) &&
         std::isfinite(reference.due_utc_s) && reference.due_utc_s > reference.issued_utc_s;
}

base::Status check_reference(const ReferenceUse& use, const std::string& where) {
  const Reference& reference = use.reference;
  if (has_empty_text(use)) return base::bad_input("name, certificate, reason and signer must not be empty", where);
  const std::size_t longest =
      std::max({reference.name.size(), reference.certificate.size(), use.waiver ? use.waiver->reason.size() : 0,
                use.waiver ? use.waiver->signer.size() : 0});
  if (longest > kMaxText) {
    return base::bad_input("a text is longer than " + std::to_string(kMaxText) + " bytes", where);
  }
  if (!bytes_of_uuid(reference.record_id)) {
    return base::bad_input("the id of its entry must be a UUID, not '" + reference.record_id + "'", where);
  }
  if (!has_sound_numbers(reference)) {
    return base::bad_input("its numbers must be finite, its uncertainty not negative, its due date after the issue",
                           where);
  }
  return {};
}

base::Status write_waiver(base::ByteWriter& out, const Waiver& waiver, const std::string& where) {
  const auto id = bytes_of_uuid(waiver.waiver_id);
  const auto key = base::bytes_of_hex<32>(waiver.public_key_hex);
  const auto signature = base::bytes_of_hex<64>(waiver.signature_hex);
  if (!id || !key || !signature || !std::isfinite(waiver.utc_s)) {
    return base::bad_input("the waiver's id must be a UUID, its key 64 and its signature 128 hexadecimal digits",
                           where);
  }
  out.write(*id);
  out.write(waiver.utc_s);
  out.write(*key);
  out.write(*signature);
  out.write(static_cast<std::uint8_t>(waiver.signer.size()));
  out.write(static_cast<std::uint8_t>(waiver.reason.size()));
  out.write(std::uint16_t{0});
  return {};
}

/// A waiver whose texts follow those of its reference.
struct WaiverHead {
  Waiver waiver;
  std::size_t signer_length = 0;
  std::size_t reason_length = 0;
};

WaiverHead read_waiver(PayloadReader& in, const std::string& record_id) {
  WaiverHead head;
  head.waiver.record_id = record_id;
  const auto id = in.bytes(16);
  if (!in.failed()) head.waiver.waiver_id = uuid_text(id);
  head.waiver.utc_s = in.number<double>();
  head.waiver.public_key_hex = base::to_hex(in.bytes(32));
  head.waiver.signature_hex = base::to_hex(in.bytes(64));
  head.signer_length = in.number<std::uint8_t>();
  head.reason_length = in.number<std::uint8_t>();
  static_cast<void>(in.number<std::uint16_t>());
  return head;
}

}  // namespace

base::Result<Section> provenance_section(const Calibration& calibration) {
  if (auto status = check_provenance(calibration); !status) return base::forward_error(status);
  base::ByteWriter out;
  out.write(calibration.epoch);
  out.write(calibration.model_version);
  out.write(calibration.created_utc_s);
  out.write(calibration.gravity_mps2);
  out.write((calibration.simulated ? kSimulated : 0U) | (calibration.gravity_assumed ? kGravityAssumed : 0U) |
            (calibration.unreleased ? kUnreleased : 0U));
  out.write(static_cast<std::uint16_t>(calibration.run_hashes.size()));
  out.write(static_cast<std::uint8_t>(calibration.unit.size()));
  out.write(static_cast<std::uint8_t>(calibration.unit_type.size()));
  for (const std::string& hex : calibration.run_hashes) {
    const auto digest = base::bytes_of_hex<32>(hex);
    if (!digest)
      return base::bad_input("a run hash must be 64 lower-case hexadecimal digits, not '" + hex + "'", "run_hashes");
    out.write(*digest);
  }
  write_text(out, calibration.unit);
  write_text(out, calibration.unit_type);
  return Section{SOAK_SECTION_PROVENANCE, true, out.take()};
}

bool says_unreleased(std::span<const std::uint8_t> payload) {
  return (soak_u32(payload.data() + 24) & kUnreleased) != 0;
}

void read_provenance(const std::uint8_t* payload, Calibration& calibration) {
  const std::size_t runs = soak_u16(payload + 28);
  base::ByteReader in({payload, 32});
  calibration.epoch = *in.read<std::int32_t>();
  calibration.model_version = *in.read<std::int32_t>();
  calibration.created_utc_s = *in.read<double>();
  calibration.gravity_mps2 = *in.read<double>();
  const auto flags = *in.read<std::uint32_t>();
  calibration.simulated = (flags & kSimulated) != 0;
  calibration.gravity_assumed = (flags & kGravityAssumed) != 0;
  calibration.unreleased = (flags & kUnreleased) != 0;
  for (std::size_t i = 0; i < runs; ++i) calibration.run_hashes.push_back(base::to_hex({payload + 32 + 32 * i, 32}));
  const std::uint8_t* text = payload + 32 + 32 * runs;
  calibration.unit.assign(text, text + payload[30]);
  text += payload[30];
  calibration.unit_type.assign(text, text + payload[31]);
}

base::Result<Section> reference_section(const ReferenceUse& use) {
  const Reference& reference = use.reference;
  const std::string where = "reference " + std::string(name_of(reference.kind)) + ' ' + reference.name;
  if (auto status = check_reference(use, where); !status) return base::forward_error(status);
  base::ByteWriter out;
  out.write(static_cast<std::uint8_t>(reference.kind));
  out.write(static_cast<std::uint8_t>((reference.correction ? kHasCorrection : 0) | (use.waiver ? kHasWaiver : 0)));
  out.write(static_cast<std::uint8_t>(reference.name.size()));
  out.write(static_cast<std::uint8_t>(reference.certificate.size()));
  for (const double number : {reference.standard_uncertainty, reference.correction.value_or(0.0),
                              reference.issued_utc_s, reference.due_utc_s}) {
    out.write(number);
  }
  out.write(*bytes_of_uuid(reference.record_id));
  if (use.waiver) {
    if (auto status = write_waiver(out, *use.waiver, where); !status) return base::forward_error(status);
  }
  write_text(out, reference.name);
  write_text(out, reference.certificate);
  if (use.waiver) {
    write_text(out, use.waiver->signer);
    write_text(out, use.waiver->reason);
  }
  return Section{kReferenceSection, false, out.take()};
}

base::Result<ReferenceUse> read_reference(std::span<const std::uint8_t> payload) {
  const auto damaged = [] {
    return base::corrupt("a reference breaks the format; export the file again", "references");
  };
  PayloadReader in(payload);
  ReferenceUse use;
  Reference& reference = use.reference;
  const auto kind = in.number<std::uint8_t>();
  const auto flags = in.number<std::uint8_t>();
  const std::size_t name_length = in.number<std::uint8_t>();
  const std::size_t certificate_length = in.number<std::uint8_t>();
  reference.standard_uncertainty = in.number<double>();
  const auto correction = in.number<double>();
  reference.issued_utc_s = in.number<double>();
  reference.due_utc_s = in.number<double>();
  const auto id = in.bytes(16);
  if (in.failed() || kind >= kReferenceKindNames.size() || !std::isfinite(correction)) return damaged();
  reference.kind = static_cast<ReferenceKind>(kind);
  reference.record_id = uuid_text(id);
  if ((flags & kHasCorrection) != 0) reference.correction = correction;
  if (!has_sound_numbers(reference)) return damaged();
  WaiverHead head;
  const bool is_waived = (flags & kHasWaiver) != 0;
  if (is_waived) head = read_waiver(in, reference.record_id);
  reference.name = in.text(name_length);
  reference.certificate = in.text(certificate_length);
  if (is_waived) {
    head.waiver.signer = in.text(head.signer_length);
    head.waiver.reason = in.text(head.reason_length);
    if (!std::isfinite(head.waiver.utc_s)) return damaged();
    use.waiver = std::move(head.waiver);
  }
  if (!in.is_whole() || has_empty_text(use)) return damaged();
  return use;
}

}  // namespace soak::calib::file
