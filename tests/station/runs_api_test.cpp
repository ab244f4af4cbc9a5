// SPDX-License-Identifier: Apache-2.0
// Stored runs over HTTP: what is asked wrongly is refused at the edge, and says where.
#include "station/http/runs_api.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "station/http/server.h"
#include "tests/errors.h"
#include "tests/station/http_raw.h"
#include "tests/station/http_scripted_station.h"
#include "tests/station/stored_runs.h"

namespace soak::station {
namespace {

using nlohmann::json;

class RunsOverHttp : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(catalog_.ensure_unit("SN1", "generic"));
    ASSERT_TRUE(catalog_.ensure_campaign("c1", "soak"));
    const db::RunRow run = testing::stored_run(catalog_, testing::StoredNumbers());
    ASSERT_TRUE(catalog_.add_run(run, db::testing::segments_of(run)));
    const auto started = server_.start();
    ASSERT_TRUE(started) << started.error().message;
    port_ = *started;
  }

  [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port_); }

  std::string get(const std::string& path) {
    return exchange_raw(port_, "GET /api/v1/" + path + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  }

  std::string post_void(const std::string& body, const std::string& headers = "Content-Type: application/json\r\n") {
    return exchange_raw(port_, "POST /api/v1/run/void HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: " +
                                   std::to_string(body.size()) + "\r\n" + headers + "\r\n" + body);
  }

  static std::string where(const std::string& answer) { return json::parse(body_of(answer))["error"]["where"]; }

  db::testing::TempFolder folder_;
  db::Catalog catalog_ = db::Catalog::open(folder_.path()).value();
  ScriptedStation lab_;
  HttpServer server_{lab_, "127.0.0.1:0", folder_.path()};
  int port_ = 0;
  const std::string run_ = std::string("run=") + testing::kStoredRunId + "&unit=SN1";
};

TEST_F(RunsOverHttp, AnswersWhatIsAsked) {
  EXPECT_EQ(json::parse(body_of(get("runs")))["runs"].size(), 1);
  EXPECT_EQ(json::parse(body_of(get("runs?campaign=c1&unit=SN1")))["runs"].size(), 1);
  EXPECT_EQ(json::parse(body_of(get("run?" + run_)))["segments"].size(), 4);
  const json series =
      json::parse(body_of(get("run/series?" + run_ + "&channel=gyro_x&channel=temp_c&from_s=1&to_s=2.5&points=500")));
  EXPECT_EQ(series["kind"], "samples");
  EXPECT_EQ(series["channels"].size(), 2);
  EXPECT_EQ(series["rows"], 151);
  EXPECT_EQ(json::parse(body_of(get("run/series?" + run_ + "&stream=chamber&channel=chamber_c")))["rows"], 1000);
}

TEST_F(RunsOverHttp, ADataFolderThatIsGoneIsNoMistakeOfWhoAsks) {
  const std::filesystem::path away = folder_.path().string() + ".away";
  std::filesystem::rename(folder_.path(), away);
  for (const std::string& answer : {get("runs"), get("run?" + run_), get("run/series?" + run_ + "&channel=gyro_x"),
                                    post_void("{\"run\": \"" + std::string(testing::kStoredRunId) +
                                              "\", \"unit\": \"SN1\", \"reason\": \"r\", \"user\": \"u\"}")}) {
    EXPECT_EQ(status_of(answer), 503);
    EXPECT_EQ(where(answer), "data");
    EXPECT_TRUE(base::mentions(body_of(answer), {folder_.path().string()}));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path()));
  std::filesystem::rename(away, folder_.path());
  EXPECT_EQ(status_of(get("runs")), 200);
}

TEST_F(RunsOverHttp, AnswersAreNotPackedForWhomTheyAreLargeAndNear) {
  const std::string answer =
      exchange_raw(port_, "GET /api/v1/run/series?" + run_ + "&channel=gyro_x HTTP/1.1\r\nHost: " + host() +
                              "\r\nAccept-Encoding: gzip, br\r\n\r\n");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_EQ(answer.find("Content-Encoding"), std::string::npos);
  EXPECT_EQ(json::parse(body_of(answer))["kind"], "buckets");
}

TEST_F(RunsOverHttp, HostileParametersAreRefusedWithTheirNames) {
  const std::string series = "run/series?" + run_;
  const std::string long_text(5000, 'x');
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"runs?units=SN1", "units"},
      {"runs?unit=", "unit"},
      {"runs?unit=a&unit=b", "unit"},
      {"run", "run"},
      {"run?run=r1&unit=SN1", "run"},
      {"run?run=..%2f..%2fetc%2fpasswd&unit=SN1", "run"},
      {"run?run=01890A5D-AC96-774B-BCCE-B302099A8057&unit=SN1", "run"},
      {"run?run=01890a5d-ac96-774b-bcce-b302099a8057%27%20OR%201=1&unit=SN1", "run"},
      {"run?run=01890a5d-ac96-774b-bcce-b302099a8058&unit=SN1", "run"},
      {"run?run=01890a5d-ac96-774b-bcce-b302099a8057&unit=SN1%00", "unit"},
      {"run?run=01890a5d-ac96-774b-bcce-b302099a8057&unit=SN1%0a", "unit"},
      {"run?run=01890a5d-ac96-774b-bcce-b302099a8057", "unit"},
      {"run?" + run_ + "&from_s=1", "from_s"},
      {series, "channel"},
      {series + "&channel=", "channel"},
      {series + "&channel=" + long_text, "channel"},
      {series + "&channel=gyro_x&stream=positions", "stream"},
      {series + "&channel=gyro_x&from_s=nan", "from_s"},
      {series + "&channel=gyro_x&from_s=inf", "from_s"},
      {series + "&channel=gyro_x&from_s=1e999", "from_s"},
      {series + "&channel=gyro_x&from_s=", "from_s"},
      {series + "&channel=gyro_x&to_s=0x10", "to_s"},
      {series + "&channel=gyro_x&from_s=10&to_s=9", "to_s"},
      {series + "&channel=gyro_x&points=0", "points"},
      {series + "&channel=gyro_x&points=-1", "points"},
      {series + "&channel=gyro_x&points=2001", "points"},
      {series + "&channel=gyro_x&points=99999999999999999999", "points"},
      {series + "&channel=gyro_x&points=1.5", "points"},
      {series + "&channel=gyro_x&points=10&points=20", "points"}};
  for (const auto& [path, place] : wrong) {
    const std::string answer = get(path);
    ASSERT_EQ(status_of(answer), 400) << path;
    EXPECT_EQ(where(answer), place) << path;
  }
  std::string many = series;
  for (int i = 0; i < 13; ++i) many += "&channel=c" + std::to_string(i);
  EXPECT_EQ(where(get(many)), "channel");
  for (const char* extreme : {"&from_s=-1e308&to_s=1e308", "&from_s=1e308", "&to_s=-1e308&from_s=-1e308"}) {
    EXPECT_EQ(status_of(get(series + "&channel=gyro_x" + extreme)), extreme == std::string("&from_s=1e308") ? 400 : 200)
        << extreme;
  }
}

TEST_F(RunsOverHttp, VoidsAsItIsTold) {
  const json record = {{"run", testing::kStoredRunId}, {"unit", "SN1"},       {"visit", 0},   {"position", "+X"},
                       {"attempt", nullptr},           {"reason", "slipped"}, {"user", "eva"}};
  const std::string answer = post_void(record.dump());
  EXPECT_EQ(status_of(answer), 200) << answer;
  EXPECT_EQ(json::parse(body_of(answer))["segments_withdrawn"], 2);
  EXPECT_EQ(catalog_.voids(testing::kStoredRunId).value().size(), 1);
}

TEST_F(RunsOverHttp, AVoidThatIsAskedForWronglyVoidsNothing) {
  const json right = {{"run", testing::kStoredRunId}, {"unit", "SN1"}, {"reason", "slipped"}, {"user", "eva"}};
  const std::vector<std::pair<std::string, json>> wrong = {{"reason", ""},
                                                           {"reason", "two\nlines"},
                                                           {"reason", std::string(201, 'x')},
                                                           {"reason", 5},
                                                           {"user", ""},
                                                           {"user", "\x1b[31m"},
                                                           {"visit", -1},
                                                           {"visit", 1.5},
                                                           {"visit", "0"},
                                                           {"visit", 4294967296},
                                                           {"attempt", 0},
                                                           {"position", 5},
                                                           {"run", "r1"},
                                                           {"force", true},
                                                           {"unit", nullptr},
                                                           {"visit", 7}};
  for (const auto& [member, value] : wrong) {
    json body = right;
    body[member] = value;
    EXPECT_EQ(status_of(post_void(body.dump())), 400) << body;
  }
  for (const char* member : {"run", "unit", "reason", "user"}) {
    json body = right;
    body.erase(member);
    EXPECT_EQ(where(post_void(body.dump())), member);
  }
  EXPECT_EQ(status_of(post_void("[]")), 400);
  EXPECT_EQ(status_of(post_void(right.dump(), "Content-Type: text/plain\r\n")), 415);
  EXPECT_EQ(status_of(post_void(right.dump(), "Content-Type: application/json\r\nOrigin: http://evil.example\r\n")),
            403);
  EXPECT_EQ(status_of(get("run/void")), 404);
  EXPECT_TRUE(catalog_.voids(testing::kStoredRunId).value().empty());
}

TEST_F(RunsOverHttp, TheLibraryThatDrawsIsServedFromTheStation) {
  const std::string answer = exchange_raw(port_, "GET /dygraph.min.js HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_NE(answer.find("Content-Type: text/javascript"), std::string::npos);
  EXPECT_EQ(status_of(exchange_raw(port_, "GET /dygraphs-licence.txt HTTP/1.1\r\nHost: " + host() + "\r\n\r\n")), 200);
}

}  // namespace
}  // namespace soak::station
