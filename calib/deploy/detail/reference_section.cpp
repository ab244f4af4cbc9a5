// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/detail/reference_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "base/hash.h"
#include "base/text.h"

namespace soak::calib::file {
namespace {

constexpr std::uint8_t kHasCorrection = 1;
constexpr std::uint8_t kHasWaiver = 2;

using Uuid = std::array<std::uint8_t, 16>;

std::optional<Uuid> bytes_of_uuid(std::string text) {
  if (text.size() != 36 || text[8] != '-' || text[13] != '-' || text[18] != '-' || text[23] != '-') return std::nullopt;
  std::erase(text, '-');
  return base::bytes_of_hex<16>(text);
}

std::string uuid_text(std::span<const std::uint8_t> bytes) {
  std::string text = base::to_hex(bytes);
  for (const std::size_t at : {8U, 13U, 18U, 23U}) text.insert(at, 1, '-');
  return text;
}

std::string place(const Reference& reference) {
  return "reference " + std::string(name_of(reference.kind)) + ' ' + reference.name;
}

base::Status check_texts(const ReferenceUse& use, const std::string& where) {
  const Reference& reference = use.reference;
  const bool has_empty = reference.name.empty() || reference.certificate.empty() ||
                         (use.waiver && (use.waiver->reason.empty() || use.waiver->signer.empty()));
  if (has_empty) return base::bad_input("name, certificate, reason and signer must not be empty", where);
  const std::size_t longest =
      std::max({reference.name.size(), reference.certificate.size(), use.waiver ? use.waiver->reason.size() : 0,
                use.waiver ? use.waiver->signer.size() : 0});
  if (longest <= kMaxText) return {};
  return base::bad_input("a text is longer than " + std::to_string(kMaxText) + " bytes", where);
}

bool are_sound(const Reference& reference) {
  return std::isfinite(reference.standard_uncertainty) && reference.standard_uncertainty >= 0.0 &&
         std::isfinite(reference.correction.value_or(0.0)) && std::isfinite(reference.issued_utc_s) &&
         std::isfinite(reference.due_utc_s) && reference.due_utc_s > reference.issued_utc_s;
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

/// Takes a payload apart; a piece that is not there leaves the reader failed.
class Pieces {
 public:
  explicit Pieces(std::span<const std::uint8_t> payload) : in_(payload) {}

  template <class T>
  T number() {
    const auto value = in_.read<T>();
    failed_ = failed_ || !value;
    return value.value_or(T{});
  }
  std::span<const std::uint8_t> bytes(std::size_t count) {
    const auto piece = in_.take(count);
    failed_ = failed_ || !piece;
    return piece.value_or(std::span<const std::uint8_t>());
  }
  std::string text(std::size_t count) {
    const auto piece = bytes(count);
    failed_ = failed_ || count == 0;
    return {piece.begin(), piece.end()};
  }
  /// Whether every piece was there and nothing but padding is left.
  [[nodiscard]] bool is_whole() const { return !failed_ && in_.remaining() < 4; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  base::ByteReader in_;
  bool failed_ = false;
};

struct WaiverHead {
  Waiver waiver;
  std::size_t signer_length = 0;
  std::size_t reason_length = 0;
};

WaiverHead read_waiver(Pieces& in, const std::string& record_id) {
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

base::Result<Section> reference_section(const ReferenceUse& use) {
  const Reference& reference = use.reference;
  const std::string where = place(reference);
  if (auto status = check_texts(use, where); !status) return base::forward_error(status);
  const auto id = bytes_of_uuid(reference.record_id);
  if (!id) return base::bad_input("the id of its entry must be a UUID, not '" + reference.record_id + "'", where);
  if (!are_sound(reference)) {
    return base::bad_input("its numbers must be finite, its uncertainty not negative, its due date after the issue",
                           where);
  }
  base::ByteWriter out;
  out.write(static_cast<std::uint8_t>(reference.kind));
  out.write(static_cast<std::uint8_t>((reference.correction ? kHasCorrection : 0) | (use.waiver ? kHasWaiver : 0)));
  out.write(static_cast<std::uint8_t>(reference.name.size()));
  out.write(static_cast<std::uint8_t>(reference.certificate.size()));
  for (const double number : {reference.standard_uncertainty, reference.correction.value_or(0.0),
                              reference.issued_utc_s, reference.due_utc_s}) {
    out.write(number);
  }
  out.write(*id);
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
  Pieces in(payload);
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
  if (!are_sound(reference)) return damaged();
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
  if (!in.is_whole()) return damaged();
  return use;
}

}  // namespace soak::calib::file
