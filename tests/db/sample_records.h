// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/db/sample_catalog.h"

/// References and waivers; the catalog of version 1 was made from them.
namespace soak::db::testing {

inline ReferenceRow probe_row(std::string certificate = "D-K-15048", double issued_utc_s = 1.7e9) {
  ReferenceRow row;
  row.reference.kind = calib::ReferenceKind::chamber_probe;
  row.reference.name = "probe 3";
  row.reference.certificate = std::move(certificate);
  row.reference.correction = -0.02;
  row.reference.standard_uncertainty = 0.025;
  row.reference.issued_utc_s = issued_utc_s;
  row.reference.due_utc_s = issued_utc_s + 3.0e7;
  row.user = "ann";
  row.entered_utc_s = issued_utc_s + 86400.5;
  return row;
}

inline ReferenceRow cube_row() {
  ReferenceRow row = probe_row("cube 7/2023");
  row.reference.kind = calib::ReferenceKind::fixture_squareness;
  row.reference.name = "cube";
  row.reference.correction.reset();
  row.reference.standard_uncertainty = 1e-4 / 3.0;
  return row;
}

inline calib::Waiver waiver_of(std::string record_id, std::string waiver_id = "01890a5d-ac96-774b-bcce-0000000000a1") {
  return {std::move(waiver_id), std::move(record_id), "laboratory is booked out",
          "Ann Example",        std::string(64, 'a'), 1.75e9,
          std::string(128, 'b')};
}

inline void expect_equal(const calib::Reference& a, const calib::Reference& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.certificate, b.certificate);
  EXPECT_EQ(a.correction, b.correction);
  EXPECT_EQ(a.standard_uncertainty, b.standard_uncertainty);
  EXPECT_EQ(a.issued_utc_s, b.issued_utc_s);
  EXPECT_EQ(a.due_utc_s, b.due_utc_s);
}

inline void expect_equal(const calib::Waiver& a, const calib::Waiver& b) {
  EXPECT_EQ(a.waiver_id, b.waiver_id);
  EXPECT_EQ(a.record_id, b.record_id);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.signer, b.signer);
  EXPECT_EQ(a.public_key_hex, b.public_key_hex);
  EXPECT_EQ(a.utc_s, b.utc_s);
  EXPECT_EQ(a.signature_hex, b.signature_hex);
}

}  // namespace soak::db::testing
