// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "tests/hal/ahrs400_peer.h"
#include "tests/hal/vectornav_peer.h"
#include "tests/hal/xsens_golden.h"
#include "tests/hal/xsens_peer.h"

namespace soak::hal::imu::test {
namespace {

/// A file with these bytes, for as long as the object lives.
class Recording {
 public:
  explicit Recording(const Bytes& bytes) {
    char name[] = "/tmp/soak-recording-XXXXXX";
    ::close(::mkstemp(name));
    path_ = name;
    std::ofstream(path_, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  ~Recording() { std::filesystem::remove(path_); }

  [[nodiscard]] RecordedAddress address() const { return {path_.string()}; }

 private:
  std::filesystem::path path_;
};

/// Polls to the end of the recording, which must be an error of the device.
std::vector<ImuSample> replay(Imu& imu, const Imu::Settings& settings) {
  std::vector<ImuSample> samples;
  EXPECT_TRUE(imu.open(settings));
  base::Status status;
  for (int i = 0; i < 1000 && status; ++i) status = imu.poll(samples);
  EXPECT_FALSE(status);
  EXPECT_EQ(imu.state(), ImuState::failed);
  if (!status) {
    EXPECT_EQ(status.error().kind, base::ErrorKind::device);
  }
  return samples;
}

TEST(Recorded, AnXsensStreamIsDecodedToItsEnd) {
  ScriptedUnit unit;
  const Recording recording(hex("01 02") + unit.packets(5000));
  const auto imu = make_imu({.address = recording.address(), .decoder = UnitDecoder::xsens});
  const auto samples = replay(*imu, {.rate_hz = 100.0});
  ASSERT_EQ(samples.size(), 5000U);
  EXPECT_DOUBLE_EQ(samples.back().t_s, 49.99);
  EXPECT_EQ(imu->statistics().garbage_bytes, 2U);
  EXPECT_FALSE(imu->identity());
}

TEST(Recorded, ARestartInTheStreamBeginsANewPowerOn) {
  ScriptedUnit unit;
  Bytes bytes = unit.packets(500);
  static_cast<void>(unit.restart());
  const Recording recording(bytes + unit.packets(500));
  const auto samples = replay(*make_imu({.address = recording.address()}), {.rate_hz = 100.0});
  ASSERT_EQ(samples.size(), 1000U);
  EXPECT_EQ(samples[499].power_on, 0U);
  EXPECT_EQ(samples[500].power_on, 1U);
}

TEST(Recorded, AnAhrs400StreamIsDecodedToItsEnd) {
  Ahrs400Unit unit;
  const Recording recording(unit.packets(3000));
  const auto imu = make_imu(
      {.address = recording.address(), .decoder = UnitDecoder::ahrs400, .ranges = {.rate_dps = 100, .accel_g = 2}});
  const auto samples = replay(*imu, {.rate_hz = 60.0});
  ASSERT_EQ(samples.size(), 3000U);
  EXPECT_NEAR(samples.back().t_s, 2999 * 0.0155, 1e-3);
}

TEST(Recorded, AVectorNavStreamIsDecodedToItsEnd) {
  const Bytes first = golden_vectornav();
  Bytes later(first.begin() + 1, first.end() - 2);
  ++later[8];  // of the time: 17 ms
  const Recording recording(line("VNRRG,03,1") + first + vectornav_frame(later));
  const auto imu = make_imu({.address = recording.address(), .decoder = UnitDecoder::vectornav});
  const auto samples = replay(*imu, {.rate_hz = 50.0});
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_NEAR(samples[0].t_s, 123.456789, 1e-3);
  EXPECT_EQ(samples[0].temp_c, 25.5F);
}

TEST(Recorded, AFileThatIsNotThereIsADeviceErrorThatNamesIt) {
  const auto imu = make_imu({.address = RecordedAddress{"/no/such/file"}});
  const auto opened = imu->open({});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().kind, base::ErrorKind::device);
  EXPECT_EQ(opened.error().where, "recording /no/such/file");
}

}  // namespace
}  // namespace soak::hal::imu::test
