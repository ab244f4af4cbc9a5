// SPDX-License-Identifier: Apache-2.0
#include "station/http/server.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "station/http/address.h"
#include "station/http/event_feed.h"
#include "tests/station/http_raw.h"
#include "tests/station/http_scripted_station.h"

namespace soak::station {
namespace {

using nlohmann::json;

class Http : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto started = server.start();
    ASSERT_TRUE(started) << started.error().message;
    port = *started;
  }

  [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port); }

  std::string get(const std::string& path, const std::string& headers = "") {
    return exchange_raw(port, "GET " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n" + headers + "\r\n");
  }

  std::string post(const std::string& path, const std::string& body,
                   const std::string& headers = "Content-Type: application/json\r\n") {
    return exchange_raw(port, "POST " + path + " HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: " +
                                  std::to_string(body.size()) + "\r\n" + headers + "\r\n" + body);
  }

  RawConnection open_events(const std::string& headers = "") {
    RawConnection events(port);
    events.send("GET /api/v1/events HTTP/1.1\r\nHost: " + host() + "\r\n" + headers + "\r\n");
    return events;
  }

  ScriptedStation lab;
  HttpServer server{lab, "127.0.0.1:0"};
  int port = 0;
};

TEST_F(Http, AnswersTheStatusAsTheLaboratoryGivesIt) {
  const std::string answer = get("/api/v1/status");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_EQ(json::parse(body_of(answer)), lab.status());
  EXPECT_NE(answer.find("Cache-Control: no-store"), std::string::npos);
  EXPECT_NE(answer.find("Content-Type: application/json"), std::string::npos);
  EXPECT_EQ(answer.find("Access-Control-"), std::string::npos);
  EXPECT_EQ(body_of(get("/api/v1/plan")), "null");
}

TEST_F(Http, HandsHistoryAndLogTheirParameters) {
  EXPECT_EQ(json::parse(body_of(get("/api/v1/history?after_s=12.5")))["after_s"], 12.5);
  for (int i = 0; i < 5; ++i) lab.add_log("entry");
  EXPECT_EQ(json::parse(body_of(get("/api/v1/log?after=3")))["entries"].size(), 2);
  EXPECT_EQ(json::parse(body_of(get("/api/v1/log")))["entries"].size(), 5);
  for (const char* path : {"/api/v1/history?after_s=nan", "/api/v1/history?after_s=", "/api/v1/log?after=1.5"}) {
    const std::string answer = get(path);
    EXPECT_EQ(status_of(answer), 400) << path;
    EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
  }
}

TEST_F(Http, HandsTheNoiseOfTheUnitThatIsAskedFor) {
  json noise = ScriptedStation::no_noise("SN0043");
  noise["samples"] = 1200;
  lab.set_noise(noise);
  EXPECT_EQ(json::parse(body_of(get("/api/v1/noise?unit=SN0043"))), noise);
  EXPECT_EQ(json::parse(body_of(get("/api/v1/noise?unit=SN0042"))), ScriptedStation::no_noise("SN0042"));
  for (const char* path : {"/api/v1/noise?unit=SN9", "/api/v1/noise?unit=", "/api/v1/noise"}) {
    const std::string answer = get(path);
    EXPECT_EQ(status_of(answer), 400) << path;
    EXPECT_EQ(json::parse(body_of(answer))["error"]["where"], "unit");
  }
}

TEST_F(Http, LogAfterANegativeNumberCountsFromTheNewest) {
  for (int i = 0; i < 700; ++i) lab.add_log("entry");
  RawConnection events = open_events("Last-Event-ID: 0\r\n");
  ASSERT_TRUE(events.read_until("id: 700\n"));  // by now the server knows of all of them
  const json entries = json::parse(body_of(get("/api/v1/log?after=-3")))["entries"];
  ASSERT_EQ(entries.size(), 3);
  EXPECT_EQ(entries[0]["number"], 698);
}

TEST_F(Http, CommandsReachTheLaboratory) {
  const std::string answer = post("/api/v1/campaign/start",
                                  R"({"procedure_text": "x = 1", "procedure_file": "soak.toml", "campaign": "c",
                                      "units": {"A": "SN1", "B": "SN2"}, "user": "eva"})");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_EQ(json::parse(body_of(answer)),
            json::parse(R"({"campaign":"c","runs":5,"steps":240,"estimate_s":126000.0,"notes":[]})"));
  EXPECT_EQ(json::parse(body_of(post("/api/v1/campaign/pause", R"({"user":"eva"})"))), json({{"state", "paused"}}));
  post("/api/v1/campaign/resume", "{}");
  EXPECT_EQ(json::parse(body_of(post("/api/v1/campaign/look", R"({"user":"eva"})"))).at("slots").size(), 1);
  post("/api/v1/campaign/queue", R"({"procedure_text": "x = 1", "campaign": "d", "user": "eva"})");
  post("/api/v1/campaign/unqueue", R"({"campaign": "d", "user": "eva"})");
  post("/api/v1/campaign/next", R"({"campaign": "e", "user": "eva"})");
  post("/api/v1/campaign/confirm", R"({"user":"eva","prompt":7})");
  post("/api/v1/campaign/abort", R"({"user":"eva","reason":"cable"})",
       "Content-Type: application/json; charset=utf-8\r\n");
  EXPECT_EQ(lab.commands(),
            (std::vector<std::string>{"start c soak.toml [x = 1] A=SN1 B=SN2 by eva", "pause by eva",
                                      "resume by unknown", "look by eva", "queue d procedure [x = 1] by eva",
                                      "unqueue d by eva", "next e by eva", "confirm 7 by eva", "abort by eva: cable"}));
}

TEST_F(Http, MalformedCommandsAreRefusedAndDoNotReachTheLaboratory) {
  const std::vector<std::pair<std::string, std::string>> malformed = {
      {"pause", ""},
      {"pause", "[]"},
      {"pause", R"({"user": 3})"},
      {"pause", R"({"usr": "eva"})"},
      {"pause", std::string(100000, '[')},
      {"abort", R"({"user": "eva"})"},
      {"abort", R"({"user": "eva", "reason": ""})"},
      {"confirm", R"({"user": "eva"})"},
      {"confirm", R"({"user": "eva", "prompt": 1.5})"},
      {"start", R"({"campaign": "c"})"},
      {"queue", R"({"campaign": "c"})"},
      {"unqueue", R"({"user": "eva"})"},
      {"next", R"({"campaign": 3})"},
      {"start", R"({"procedure_text": "x", "campaign": "c", "units": ["SN1"]})"},
      {"start", R"({"procedure_text": "x", "campaign": "c", "units": {"A": 1}})"}};
  for (const auto& [command, body] : malformed) {
    const std::string answer = post("/api/v1/campaign/" + command, body);
    EXPECT_EQ(status_of(answer), 400) << command << " " << body.substr(0, 80);
    EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
  }
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(Http, ErrorsOfTheLaboratoryHaveTheStatusOfTheirKind) {
  const std::vector<std::pair<base::Error, int>> kinds = {{{base::ErrorKind::bad_input, "m", "soak.toml:3"}, 400},
                                                          {{base::ErrorKind::bad_input, "m", "state"}, 409},
                                                          {{base::ErrorKind::device, "m", "chamber"}, 502},
                                                          {{base::ErrorKind::internal, "m", ""}, 500},
                                                          {{base::ErrorKind::corrupt, "m", ""}, 500}};
  for (const auto& [error, status] : kinds) {
    lab.fail_next(error);
    const std::string answer = post("/api/v1/campaign/pause", "{}");
    EXPECT_EQ(status_of(answer), status);
    EXPECT_EQ(json::parse(body_of(answer)),
              json({{"error", {{"code", static_cast<int>(error.kind)}, {"message", "m"}, {"where", error.where}}}}));
  }
}

TEST_F(Http, UnknownPathsAndMethodsAnswerWithAnErrorDocument) {
  for (const std::string& answer : {get("/api/v1/nothing"), get("/nothing.html"), get("/../etc/passwd"),
                                    get("/api/v1/campaign/pause"), post("/api/v1/status", "{}")}) {
    EXPECT_EQ(status_of(answer), 404) << answer;
    EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
  }
}

TEST_F(Http, CommandsMustBeJson) {
  for (const char* type : {"", "Content-Type: text/plain\r\n", "Content-Type: application/x-www-form-urlencoded\r\n",
                           "Content-Type: application/jsonx\r\n"}) {
    EXPECT_EQ(status_of(post("/api/v1/campaign/pause", "{}", type)), 415) << type;
  }
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(Http, RequestsForAnotherHostAreRefused) {
  const auto status_for = [this](const std::string& host_header) {
    return status_of(exchange_raw(port, "GET /api/v1/status HTTP/1.1\r\n" + host_header + "\r\n"));
  };
  const std::string tail = ":" + std::to_string(port) + "\r\n";
  for (const std::string& good : {"127.0.0.1" + tail, "localhost" + tail, "LOCALHOST" + tail, "[::1]" + tail,
                                  std::string("localhost\r\n"), std::string("localhost:9000\r\n")}) {
    EXPECT_EQ(status_for("Host: " + good), 200) << good;
  }
  for (const std::string& bad : {"evil.example" + tail, "127.0.0.1.evil.example" + tail, "192.168.1.5" + tail,
                                 "localhost.evil.example" + tail, std::string("\r\n")}) {
    EXPECT_EQ(status_for("Host: " + bad), 403) << bad;
  }
  EXPECT_EQ(status_for(""), 403);
  const std::string page = exchange_raw(port, "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(status_of(page), 403);
}

TEST_F(Http, TheMachinesOwnNameAndThoseOfTheConfigurationAreAnswered) {
  HttpServer named(lab, "127.0.0.1:0", {}, {"soak.lab.example"});
  const int port_of_named = *named.start();
  const auto status_for = [&](const std::string& name) {
    return status_of(exchange_raw(port_of_named, "GET /api/v1/status HTTP/1.1\r\nHost: " + name + "\r\n\r\n"));
  };
  EXPECT_EQ(status_for("soak.lab.example"), 200);
  EXPECT_EQ(status_for("Soak.Lab.Example:8088"), 200);
  EXPECT_EQ(status_for("lab.example"), 403);
  EXPECT_EQ(status_for("soak.lab.example.evil.example"), 403);
  std::array<char, 256> machine{};
  ASSERT_EQ(::gethostname(machine.data(), machine.size() - 1), 0);
  EXPECT_EQ(status_for(machine.data()), 200);
}

TEST_F(Http, ABrowserThatUsesAnotherNameGetsAPageThatNamesTheRightAddress) {
  const std::string answer =
      exchange_raw(port, "GET / HTTP/1.1\r\nHost: <b>\r\nAccept: text/html,application/xhtml+xml\r\n\r\n");
  EXPECT_EQ(status_of(answer), 403);
  EXPECT_NE(answer.find("Content-Type: text/html"), std::string::npos) << answer;
  EXPECT_NE(answer.find("href=\"http://127.0.0.1:"), std::string::npos) << answer;
  EXPECT_EQ(answer.find("<b>"), std::string::npos) << answer;
}

TEST_F(Http, RequestsFromPagesOfAnotherOriginAreRefused) {
  const auto status_from = [this](const std::string& origin) {
    return status_of(
        post("/api/v1/campaign/pause", "{}", "Content-Type: application/json\r\nOrigin: " + origin + "\r\n"));
  };
  EXPECT_EQ(status_from("http://" + host()), 200);
  for (const std::string& bad :
       {std::string("http://evil.example"), std::string("null"), "http://localhost:" + std::to_string(port),
        "http://" + host() + ".evil.example", std::string("http://127.0.0.1:1")}) {
    EXPECT_EQ(status_from(bad), 403) << bad;
  }
  EXPECT_EQ(lab.commands().size(), 1);
}

// A refused request whose body spells another one must not be answered twice: a page of another site could send
// commands that way.
TEST_F(Http, TheBodyOfARefusedRequestIsNeverTakenForTheNextOne) {
  const std::string inner = "POST /api/v1/campaign/pause HTTP/1.1\r\nHost: " + host() +
                            "\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}";
  const std::string answer = post("/api/v1/campaign/pause", inner, "Content-Type: text/plain\r\n");
  EXPECT_EQ(status_of(answer), 415);
  get("/api/v1/status", "Content-Length: " + std::to_string(inner.size()) + "\r\n\r\n" + inner);
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(Http, BodiesAboveOneMebibyteAreRefused) {
  const auto with_text = [](std::size_t size) {
    const std::string rest = R"({"campaign":"c","procedure_text":""})";
    return R"({"campaign":"c","procedure_text":")" + std::string(size - rest.size(), 'x') + "\"}";
  };
  const std::size_t limit = std::size_t{1} << 20;
  EXPECT_EQ(status_of(post("/api/v1/campaign/start", with_text(limit))), 200);
  const std::string answer = post("/api/v1/campaign/start", with_text(limit + 1));
  EXPECT_EQ(status_of(answer), 413);
  EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
  EXPECT_EQ(lab.commands().size(), 1);
}

TEST_F(Http, ABodyWithoutAStatedLengthIsRefused) {
  const std::string answer = exchange_raw(port, "POST /api/v1/campaign/pause HTTP/1.1\r\nHost: " + host() +
                                                    "\r\nContent-Type: application/json\r\n"
                                                    "Transfer-Encoding: chunked\r\n\r\n"
                                                    "f\r\n{\"user\": \"eva\"}\r\n0\r\n\r\n");
  EXPECT_EQ(status_of(answer), 411);
  EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
  EXPECT_TRUE(lab.commands().empty());
}

TEST_F(Http, NamesAndReasonsAreOneLineOfTwoHundredBytesAtMost) {
  const auto start = [](const std::string& member, const std::string& value) {
    json body = {{"procedure_text", "two\nlines"}, {"campaign", "c"}, {"user", "eva"}};
    body[member] = value;
    return std::pair{std::string("/api/v1/campaign/start"), body};
  };
  const auto abort = [](const std::string& member, const std::string& value) {
    json body = {{"user", "eva"}, {"reason", "r"}};
    body[member] = value;
    return std::pair{std::string("/api/v1/campaign/abort"), body};
  };
  const auto status = [&](const std::pair<std::string, json>& command) {
    const std::string answer = post(command.first, command.second.dump());
    if (status_of(answer) != 200) {
      EXPECT_EQ(json::parse(body_of(answer))["error"]["code"], 2);
    }
    return status_of(answer);
  };
  using Command = std::function<std::pair<std::string, json>(const std::string&)>;
  const std::vector<Command> commands = {
      [&](const std::string& text) { return start("campaign", text); },
      [&](const std::string& text) { return start("user", text); },
      [&](const std::string& text) { return abort("reason", text); },
      [&](const std::string& text) { return abort("user", text); },
  };
  for (std::size_t i = 0; i < commands.size(); ++i) {
    for (const std::string& text : {std::string("two\nlines"), std::string("tab\t"), std::string("\x1b[2J"),
                                    std::string("\x7f"), std::string("a\0b", 3), std::string(201, 'x'),
                                    std::string("\u009b2J"), std::string("\u202etxt"), std::string("\u00a0")}) {
      EXPECT_EQ(status(commands[i](text)), 400) << i << " " << json(text);
    }
  }
  EXPECT_TRUE(lab.commands().empty());
  for (const Command& command : commands) {
    EXPECT_EQ(status(command(std::string(200, 'x'))), 200);
    EXPECT_EQ(status(command("Prüfung 3, −20 °C")), 200);
  }
  EXPECT_EQ(lab.commands().size(), 2 * commands.size());
}

TEST_F(Http, PagesComeWithSecurityHeaders) {
  const std::string page = get("/");
  EXPECT_EQ(status_of(page), 200);
  EXPECT_NE(page.find("Content-Type: text/html; charset=utf-8"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'self'"), std::string::npos);
  EXPECT_NE(page.find("X-Content-Type-Options: nosniff"), std::string::npos);
  EXPECT_NE(get("/app.mjs").find("Content-Type: text/javascript"), std::string::npos);
  EXPECT_EQ(body_of(page), body_of(get("/index.html")));
}

TEST_F(Http, AnAddressInUseIsRefusedAndNamed) {
  HttpServer second(lab, host());
  const auto started = second.start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(started.error().where, host());
  EXPECT_EQ(status_of(get("/api/v1/status")), 200);
}

TEST(HttpAddress, TextThatIsNoAddressIsRefused) {
  ScriptedStation lab;
  for (const char* text : {"", "8088", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", ":8088",
                           "::1:8088", "127.0.0.1:80x"}) {
    EXPECT_FALSE(HttpServer(lab, text).start()) << text;
  }
  EXPECT_FALSE(HttpServer(lab, "192.0.2.1:0").start());  // RFC 5737: nobody has this address
}

TEST(HttpAddress, OfAStationMayBeThatOfItsPage) {
  for (const auto& [text, host, tls] :
       std::vector<std::tuple<std::string, std::string, bool>>{{"lab-pc:8088", "lab-pc", false},
                                                               {"http://lab-pc:8088/", "lab-pc", false},
                                                               {"https://lab-pc:8088", "lab-pc", true},
                                                               {"https://[::1]:8088/", "::1", true}}) {
    const auto station = parse_station_address(text);
    ASSERT_TRUE(station) << text;
    EXPECT_EQ(station->address.host, host);
    EXPECT_EQ(station->address.port, 8088);
    EXPECT_EQ(station->tls, tls);
  }
  for (const char* text :
       {"https://", "https://lab-pc", "ftp://lab-pc:21", "lab-pc:8088/", "https://lab-pc:8088/page"}) {
    EXPECT_FALSE(parse_station_address(text)) << text;
  }
}

TEST(HttpAddress, IsOfTheMachineAloneForLoopback) {
  for (const char* host : {"127.0.0.1", "127.8.9.1", "::1", "localhost"})
    EXPECT_TRUE(is_loopback({host, 8088})) << host;
  for (const char* host : {"0.0.0.0", "::", "192.168.7.20", "127.lab.example", "localhost.lab.example", "lab-pc"}) {
    EXPECT_FALSE(is_loopback({host, 8088})) << host;
  }
}

TEST_F(Http, WithoutATlsCertificateNobodyIsAskedWhoHeIs) {
  EXPECT_EQ(json::parse(body_of(get("/api/v1/session"))),
            json({{"accounts", false}, {"name", nullptr}, {"role", nullptr}}));
  EXPECT_EQ(status_of(post("/api/v1/login", R"({"name": "eva", "password": "x"})")), 404);
  lab.set("/chamber/connected", false);
  EXPECT_EQ(json::parse(body_of(get("/api/v1/alive")))["chamber_connected"], false);
}

// The library's own packing costs half a second of a processor each time the page is opened.
TEST_F(Http, NothingIsPackedForWhoIsNear) {
  for (const char* path : {"/", "/app.mjs", "/style.css", "/api/v1/status", "/api/v1/nothing"}) {
    const std::string answer = exchange_raw(
        port, std::string("GET ") + path + " HTTP/1.1\r\nHost: " + host() + "\r\nAccept-Encoding: gzip, br\r\n\r\n");
    EXPECT_EQ(answer.find("Content-Encoding"), std::string::npos) << path;
    EXPECT_NE(answer.find("Content-Length: "), std::string::npos) << path;
    EXPECT_GT(body_of(answer).size(), 10) << path;
  }
}

TEST_F(Http, AStoppedServerLetsGoOfItsAddress) {
  server.stop();
  EXPECT_FALSE(RawConnection(port).connected());
  HttpServer second(lab, host());
  EXPECT_TRUE(second.start());
  EXPECT_EQ(status_of(get("/api/v1/status")), 200);
}

TEST_F(Http, EventsBeginWithTheStatusAndFollowItsChanges) {
  RawConnection events = open_events("Accept-Encoding: gzip, br\r\n");
  ASSERT_TRUE(events.read_until("event: status\ndata: {"));
  EXPECT_NE(events.text().find("Content-Type: text/event-stream"), std::string::npos);
  EXPECT_NE(events.text().find("Cache-Control: no-store"), std::string::npos);
  lab.set("/campaign/step", 31);
  EXPECT_TRUE(events.read_until("\"step\":31,"));
  lab.set("/prompt", {{"id", 4}, {"text", "Turn the fixture.\nThen confirm."}});
  EXPECT_TRUE(events.read_until("Turn the fixture.\\nThen confirm."));
}

TEST_F(Http, EventsCarryNewLogEntriesWithTheirNumbers) {
  lab.add_log("before");
  RawConnection probe = open_events("Last-Event-ID: 0\r\n");
  ASSERT_TRUE(probe.read_until("id: 1\nevent: log\ndata: "));
  RawConnection events = open_events();
  ASSERT_TRUE(events.read_until("event: status"));
  lab.add_log("after");
  ASSERT_TRUE(events.read_until("id: 2\nevent: log\ndata: {"));
  EXPECT_EQ(events.text().find("\"before\""), std::string::npos);
}

TEST_F(Http, EventsGoOnAfterTheLastOneThatTheClientHasSeen) {
  for (int i = 1; i <= 1203; ++i) lab.add_log("entry");
  RawConnection all = open_events("Last-Event-ID: 0\r\n");
  ASSERT_TRUE(all.read_until("id: 1203\n"));  // more than the 500 of one answer
  EXPECT_EQ(all.count("event: log"), 1203);
  RawConnection some = open_events("Last-Event-ID: 1201\r\n");
  ASSERT_TRUE(some.read_until("id: 1203\n"));
  EXPECT_EQ(some.count("event: log"), 2);
}

TEST(EventStream, SendsNothingTwiceToAClientThatHasSeenMoreThanTheFeed) {
  ScriptedStation lab;
  const EventFeed feed(lab);
  for (int i = 1; i <= 3; ++i) lab.add_log("entry");  // the feed looks a fifth of a second later
  EventStream stream(lab, feed, 2);
  std::string text;
  while (text.find("id: 3\n") == std::string::npos) text += stream.next().value();
  EXPECT_EQ(text.find("id: 1\n"), std::string::npos);
  EXPECT_EQ(text.find("id: 2\n"), std::string::npos);
}

TEST_F(Http, AnEventNumberOfAnotherLogDoesNotSilenceTheStream) {
  RawConnection events = open_events("Last-Event-ID: 99\r\n");
  ASSERT_TRUE(events.read_until("event: status"));
  lab.add_log("new");
  EXPECT_TRUE(events.read_until("id: 1\n"));
}

TEST_F(Http, TextThatIsNotUtf8DoesNotBreakTheStream) {
  RawConnection events = open_events();
  lab.set("/reason", "bad \xff byte");
  EXPECT_TRUE(events.read_until("bad \xEF\xBF\xBD byte"));
}

TEST_F(Http, SixtyEventStreamsLeaveRoomForOtherRequestsAndShareOneLook) {
  std::vector<RawConnection> streams;
  for (int i = 0; i < 60; ++i) streams.push_back(open_events());
  for (RawConnection& stream : streams) ASSERT_TRUE(stream.read_until("event: status"));
  const std::size_t calls = lab.status_calls();
  lab.set("/campaign/step", 32);
  for (RawConnection& stream : streams) ASSERT_TRUE(stream.read_until("\"step\":32,"));
  EXPECT_EQ(lab.status_calls(), calls + 1);
  EXPECT_EQ(status_of(get("/api/v1/status")), 200);
}

TEST_F(Http, StreamsBeyondTheLimitAreRefusedAndPlacesBecomeFreeAgain) {
  {
    std::vector<RawConnection> streams;
    for (int i = 0; i < 80; ++i) streams.push_back(open_events());
    for (RawConnection& stream : streams) ASSERT_TRUE(stream.read_until("event: status"));
    EXPECT_EQ(status_of(get("/api/v1/events")), 503);
    EXPECT_EQ(status_of(get("/api/v1/status")), 200);
  }
  for (;;) {  // until the server has noticed that they are gone
    RawConnection stream = open_events();
    if (stream.read_until("event: status")) break;
    ASSERT_EQ(status_of(stream.text()), 503);
  }
}

TEST_F(Http, StopEndsOpenStreamsInOrder) {
  std::vector<RawConnection> streams;
  for (int i = 0; i < 8; ++i) streams.push_back(open_events());
  for (RawConnection& stream : streams) ASSERT_TRUE(stream.read_until("event: status"));
  server.stop();
  // The last chunk of a chunked body: the stream was ended, not cut.
  for (RawConnection& stream : streams) EXPECT_TRUE(stream.read_all().ends_with("\r\n0\r\n\r\n"));
}

}  // namespace
}  // namespace soak::station
