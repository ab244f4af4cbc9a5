// SPDX-License-Identifier: Apache-2.0
// References on their way out of the laboratory: calibration file, JSON, model document, the text of a waiver.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "calib/deploy/calibration_file.h"
#include "calib/deploy/export.h"
#include "calib/deploy/signature.h"
#include "calib/model/document_parts.h"
#include "calib/model/model_document.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using samples::golden_fis;
using samples::golden_referenced;
using samples::references;

constexpr std::uint16_t kReferenceSection = 0x0002;

void expect_equal(const ReferenceUse& a, const ReferenceUse& b) {
  EXPECT_EQ(a.reference.record_id, b.reference.record_id);
  EXPECT_EQ(a.reference.kind, b.reference.kind);
  EXPECT_EQ(a.reference.name, b.reference.name);
  EXPECT_EQ(a.reference.certificate, b.reference.certificate);
  EXPECT_EQ(a.reference.correction, b.reference.correction);
  EXPECT_EQ(a.reference.standard_uncertainty, b.reference.standard_uncertainty);
  EXPECT_EQ(a.reference.issued_utc_s, b.reference.issued_utc_s);
  EXPECT_EQ(a.reference.due_utc_s, b.reference.due_utc_s);
  ASSERT_EQ(a.waiver.has_value(), b.waiver.has_value());
  if (!a.waiver) return;
  EXPECT_EQ(a.waiver->waiver_id, b.waiver->waiver_id);
  EXPECT_EQ(a.waiver->record_id, b.waiver->record_id);
  EXPECT_EQ(a.waiver->reason, b.waiver->reason);
  EXPECT_EQ(a.waiver->signer, b.waiver->signer);
  EXPECT_EQ(a.waiver->public_key_hex, b.waiver->public_key_hex);
  EXPECT_EQ(a.waiver->utc_s, b.waiver->utc_s);
  EXPECT_EQ(a.waiver->signature_hex, b.waiver->signature_hex);
}

void expect_equal(const std::vector<ReferenceUse>& a, const std::vector<ReferenceUse>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) expect_equal(a[i], b[i]);
}

TEST(ReferencesInTheFile, ComeBackToTheLastBit) {
  const auto read = decode(*encode(golden_referenced()));
  ASSERT_TRUE(read) << read.error().message;
  expect_equal(read->references, references());
}

TEST(ReferencesInTheFile, LeaveTheCurvesAndReadersInFlightAlone) {
  const base::Bytes with = *encode(golden_referenced());
  const base::Bytes without = *encode(golden_fis());
  soak_cal a;
  soak_cal b;
  ASSERT_EQ(soak_load(&a, with.data(), with.size()), SOAK_OK);
  ASSERT_EQ(soak_load(&b, without.data(), without.size()), SOAK_OK);
  EXPECT_EQ(samples::get<std::uint16_t>(with, 10), 2) << "minor version";
  EXPECT_EQ(samples::get<std::uint16_t>(without, 10), 0);
  for (float temp_c = -40.0F; temp_c < 80.0F; temp_c += 7.3F) {
    for (int sensor = 0; sensor < 6; ++sensor) {
      float x = NAN;
      float y = NAN;
      EXPECT_EQ(soak_bias(&a, sensor, temp_c, &x), soak_bias(&b, sensor, temp_c, &y));
      EXPECT_EQ(x, y);
    }
  }
}

TEST(ReferencesInTheFile, AreRefusedWhereTheFormatCannotCarryThem) {
  const std::vector<std::pair<const char*, std::function<void(std::vector<ReferenceUse>&)>>> cases = {
      {"no id", [](auto& uses) { uses[0].reference.record_id = "probe"; }},
      {"upper-case id", [](auto& uses) { uses[0].reference.record_id[0] = 'A'; }},
      {"no name", [](auto& uses) { uses[0].reference.name.clear(); }},
      {"long name", [](auto& uses) { uses[0].reference.name.assign(256, 'x'); }},
      {"no certificate", [](auto& uses) { uses[0].reference.certificate.clear(); }},
      {"NaN", [](auto& uses) { uses[0].reference.standard_uncertainty = NAN; }},
      {"negative", [](auto& uses) { uses[0].reference.standard_uncertainty = -1.0; }},
      {"correction", [](auto& uses) { uses[0].reference.correction = INFINITY; }},
      {"due before issue", [](auto& uses) { uses[0].reference.due_utc_s = uses[0].reference.issued_utc_s; }},
      {"no reason", [](auto& uses) { uses[1].waiver->reason.clear(); }},
      {"long reason", [](auto& uses) { uses[1].waiver->reason.assign(256, 'x'); }},
      {"no signer", [](auto& uses) { uses[1].waiver->signer.clear(); }},
      {"short key", [](auto& uses) { uses[1].waiver->public_key_hex.pop_back(); }},
      {"foreign digit", [](auto& uses) { uses[1].waiver->signature_hex[0] = 'g'; }},
      {"waiver's time", [](auto& uses) { uses[1].waiver->utc_s = NAN; }},
      {"161 references", [](auto& uses) { uses.assign(161, uses[0]); }},
  };
  for (const auto& [what, change] : cases) {
    Calibration calibration = golden_referenced();
    change(calibration.references);
    const auto bytes = encode(calibration);
    ASSERT_FALSE(bytes) << what;
    EXPECT_EQ(bytes.error().kind, base::ErrorKind::bad_input) << what;
  }
  Calibration full = golden_referenced();
  full.references.assign(160, full.references[1]);
  const auto bytes = encode(full);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(decode(*bytes)->references.size(), 160U);
}

/// Offsets of the payloads of references in a file.
std::vector<std::size_t> payloads(const base::Bytes& bytes) {
  std::vector<std::size_t> found;
  for (std::size_t at = samples::get<std::uint32_t>(bytes, 16); at + 12 < bytes.size();
       at += 8 + samples::get<std::uint32_t>(bytes, at + 4)) {
    if (samples::get<std::uint16_t>(bytes, at) == kReferenceSection) found.push_back(at + 8);
  }
  return found;
}

TEST(ReferencesInTheFile, ThatBreakTheFormatAreRefusedAsDamage) {
  const base::Bytes good = *encode(golden_referenced());
  const auto at = payloads(good);
  ASSERT_EQ(at.size(), 2U);
  const auto is_damaged = [&](const std::function<void(base::Bytes&)>& change) {
    base::Bytes bytes = good;
    change(bytes);
    samples::seal(bytes);
    const auto read = decode(bytes);
    return !read && read.error().kind == base::ErrorKind::corrupt;
  };
  EXPECT_FALSE(is_damaged([](base::Bytes&) {}));
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { bytes[at[0]] = 6; })) << "kind";
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { bytes[at[0] + 2] = 0; })) << "no name";
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { bytes[at[0] + 3] = 200; })) << "long certificate";
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { bytes[at[1] + 1] = 0; })) << "a waiver that nobody announced";
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { bytes[at[0] + 1] = 3; })) << "a waiver that is not there";
  for (const std::size_t number : {4U, 12U, 20U, 28U}) {
    EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { samples::put(bytes, at[0] + number, std::nan("")); })) << number;
  }
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { samples::put(bytes, at[0] + 4, -1.0); })) << "uncertainty";
  EXPECT_TRUE(is_damaged([&](base::Bytes& bytes) { samples::put(bytes, at[1] + 68, std::nan("")); }))
      << "waiver's time";
  base::Bytes cut = *encode(golden_fis());
  samples::append_section(cut, kReferenceSection, 1, false, {0, 0, 1, 1});
  EXPECT_EQ(decode(cut).error().kind, base::ErrorKind::corrupt);
}

TEST(ReferencesInTheFile, WithAnyWrongBitAreDamageOrAnotherReference) {
  Calibration small = samples::with_bias(TableCurve{-30.0, 50.0, {0.1, 0.2, 0.3}});
  small.references = references();
  const base::Bytes good = *encode(small);
  int refused = 0;
  for (const std::size_t payload : payloads(good)) {
    const std::size_t size = samples::get<std::uint32_t>(good, payload - 4);
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      base::Bytes bytes = good;
      bytes[payload + bit / 8] = static_cast<std::uint8_t>(bytes[payload + bit / 8] ^ (1U << bit % 8));
      samples::seal(bytes);
      const auto read = decode(bytes);
      if (!read) {
        EXPECT_EQ(read.error().kind, base::ErrorKind::corrupt) << "bit " << bit;
        ++refused;
        continue;
      }
      ASSERT_EQ(read->references.size(), 2U);
      EXPECT_TRUE(encode(*read)) << "what is read can be written, bit " << bit;
    }
  }
  EXPECT_GT(refused, 0);
}

TEST(ReferencesInTheFile, OfALaterLayoutArePassedOver) {
  base::Bytes later = *encode(golden_fis());
  samples::append_section(later, kReferenceSection, 2, false, {1, 2, 3, 4});
  const auto read = decode(later);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(read->references.empty());
}

TEST(ReferencesInJson, StandInTheUnitsOfPeople) {
  const auto text = export_json(golden_referenced());
  ASSERT_TRUE(text) << text.error().message;
  const json list = json::parse(*text)["references"];
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0]["unit"], "K");
  EXPECT_EQ(list[0]["correction"], -0.02);
  EXPECT_EQ(list[0]["standard_uncertainty"], 0.025);
  EXPECT_EQ(list[0]["due_utc"], "2027-01-01T00:00:00Z");
  EXPECT_TRUE(list[0]["waiver"].is_null());
  EXPECT_EQ(list[1]["unit"], "deg");
  EXPECT_TRUE(list[1]["correction"].is_null());
  // 1e-4 rad, to the last digits of a product of two rounded numbers
  EXPECT_NEAR(list[1]["standard_uncertainty"].get<double>(), 1e-4 * 180.0 / std::numbers::pi, 1e-18);
  EXPECT_EQ(list[1]["waiver"]["signer"], "Ann Example");
  EXPECT_EQ(list[1]["waiver"]["signed_utc"], "2025-12-01T12:00:00Z");
  EXPECT_EQ(json::parse(*export_json(golden_fis()))["references"], json::array());
}

TEST(ReferencesInTheModelDocument, ComeBackToTheLastBit) {
  std::vector<ReferenceUse> uses = references();
  uses[0].reference.standard_uncertainty = 0.1 / 3.0;
  uses[0].reference.correction = -1.0 / 3.0;
  uses[0].campaigns = {"spring", "autumn"};
  const auto back = references_of(json::parse(stored_references(uses).dump()));
  ASSERT_TRUE(back) << back.error().message;
  expect_equal(*back, uses);
  EXPECT_EQ((*back)[0].campaigns, uses[0].campaigns);
  EXPECT_TRUE((*back)[1].campaigns.empty());
}

TEST(ReferencesInTheModelDocument, ReachTheCalibrationOfALaterExport) {
  UnitModel model;
  model.unit = "SN1";
  model.references = references();
  const auto document = model_document(model);
  ASSERT_TRUE(document) << document.error().message;
  EXPECT_EQ(json::parse(*document)["fit"]["references"].size(), 2U);
  const auto calibration = calibration_of(*document);
  ASSERT_TRUE(calibration) << calibration.error().message;
  expect_equal(calibration->references, references());
  json damaged = json::parse(*document);
  damaged["calibration"]["references"][0]["kind"] = "hourglass";
  EXPECT_EQ(calibration_of(damaged.dump()).error().kind, base::ErrorKind::corrupt);
  damaged["calibration"]["references"][0].erase("kind");
  EXPECT_EQ(calibration_of(damaged.dump()).error().kind, base::ErrorKind::corrupt);
  damaged["calibration"].erase("references");
  EXPECT_TRUE(calibration_of(damaged.dump())->references.empty()) << "models from before have none";
}

TEST(WaiverText, IsWhatTheDocumentationSays) {
  const auto use = references()[1];
  EXPECT_EQ(waiver_text(*use.waiver, use.reference),
            "soak-waiver-1\n"
            "waiver 019ada3c-9e00-7a10-8000-00000000a11e\n"
            "reference 018cc251-f400-7c3e-8000-0000000000c2\n"
            "kind fixture_squareness\n"
            "name cube 7\n"
            "certificate PTB 5.31-4012\n"
            "due 2025-01-01T00:00:00Z\n"
            "reason a new cube is ordered; its faces were compared on 2025-11-28\n"
            "signer Ann Example\n"
            "signed 2025-12-01T12:00:00Z\n");
}

TEST(WaiverText, CannotBeMadeToReadOtherwise) {
  auto use = references()[1];
  use.waiver->reason = "fine\nsigner Bob";
  EXPECT_EQ(waiver_text(*use.waiver, use.reference).error().kind, base::ErrorKind::bad_input);
  use = references()[1];
  use.reference.certificate += '\r';
  EXPECT_FALSE(waiver_text(*use.waiver, use.reference));
}

}  // namespace
}  // namespace soak::calib
