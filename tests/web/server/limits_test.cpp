#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <deque>

#include "web/server/frames.h"
#include "web/server/served.h"

namespace rubicon::web::server {
namespace {

using testing::HasSubstr;

const std::string kAsk = "GET /api/v1/a HTTP/1.1\r\nHost: localhost\r\n\r\n";
const std::string kAskForever = "GET /api/v1/never HTTP/1.1\r\nHost: localhost\r\n\r\n";

using WebLimits = ServedTest;

TEST_F(WebLimits, AHeadThatComesByteByByteIsGivenUp) {
  serve();
  const auto slow = client();
  const std::string head = "GET / HTTP/1.1\r\nHost: localhost\r\nX: ";
  for (int second = 0; second < 9; ++second) {
    slow->send(head.substr(static_cast<std::size_t>(second), 1));
    world.pass(1s);
  }
  EXPECT_EQ(server->connections(), 1U);
  slow->send("T");
  world.pass(1s);
  EXPECT_TRUE(slow->gets("HTTP/1.1 408"));
  EXPECT_TRUE(slow->is_closed());
  EXPECT_EQ(server->connections(), 0U);
}

TEST_F(WebLimits, AConnectionThatAsksNothingIsClosed) {
  serve();
  const auto silent = client();
  world.pass(10s);
  EXPECT_TRUE(silent->is_closed());
  EXPECT_TRUE(silent->received.empty());
}

TEST_F(WebLimits, AConnectionThatAskedBeforeStaysAMinute) {
  serve();
  const auto browser = client();
  browser->send(kAsk);
  ASSERT_TRUE(browser->gets("/api/v1/a"));
  world.pass(59s);
  EXPECT_EQ(server->connections(), 1U);
  world.pass(1s);
  EXPECT_TRUE(browser->is_closed());
}

/// What a server in front may take for the body of the first request, and this one for another request.
TEST_F(WebLimits, ABodyThatEndsWhereNobodyKnowsIsNoSecondRequest) {
  serve();
  for (const auto* fields :
       {"Transfer-Encoding: xchunked", "Transfer-Encoding: gzip", "Transfer-Encoding: chunked, gzip",
        "Transfer-Encoding: gzip, chunked", "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked",
        "Transfer-Encoding: identity", "Transfer-Encoding: chunked\r\nContent-Length: 3",
        "Content-Length: 0\r\nContent-Length: 0"}) {
    const auto sly = client();
    sly->send(std::string("PUT /api/v1/b HTTP/1.1\r\nHost: localhost\r\n") + fields + "\r\n\r\n" + kAsk);
    EXPECT_TRUE(sly->is_closed()) << fields;
    EXPECT_THAT(sly->received, testing::AnyOf(HasSubstr("HTTP/1.1 400"), HasSubstr("HTTP/1.1 501"))) << fields;
    EXPECT_EQ(sly->received.find("/api/v1/a"), std::string::npos) << fields;
  }
  EXPECT_TRUE(site.requests.empty());
  const auto honest = client();
  honest->send("PUT /api/v1/b HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: Chunked\r\n\r\n1\r\nx\r\n0\r\n\r\n");
  EXPECT_TRUE(honest->gets("HTTP/1.1 200"));
}

/// RFC 9112, section 6.1: an agent in front that speaks HTTP/1.0 knows no transfer codings.
TEST_F(WebLimits, ATransferCodingOfHttp10IsRefused) {
  serve();
  const auto sly = client();
  sly->send("PUT /api/v1/b HTTP/1.0\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nx\r\n0\r\n\r\n");
  EXPECT_TRUE(sly->is_closed());
  EXPECT_THAT(sly->received, HasSubstr(" 400 "));
  EXPECT_TRUE(site.requests.empty());
}

std::string upload_of(std::size_t size, const std::string& path = "/api/v1/upload") {
  return fmt::format("POST {} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {}\r\n\r\n", path, size);
}

TEST_F(WebLimits, OnlyAnUploadMayBeLongerThanARequest) {
  serve();
  constexpr std::size_t kSize = 2 << 20;
  const auto other = client();
  other->send(upload_of(kSize, "/api/v1/a"));
  EXPECT_TRUE(other->gets("HTTP/1.1 413")) << "by its head alone";
  const auto sly = client();
  sly->send("POST /api/v1/a HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n180000\r\n" +
            std::string(0x180000, 'x') + "\r\n0\r\n\r\n");
  EXPECT_TRUE(sly->gets("HTTP/1.1 413"));
  EXPECT_TRUE(site.requests.empty());
  const auto file = client();
  file->send(upload_of(kSize) + std::string(kSize, 'x'));
  ASSERT_TRUE(file->gets("HTTP/1.1 200"));
  EXPECT_EQ(site.requests.back().body.size(), kSize);
  const auto huge = client();
  huge->send(upload_of((32 << 20) + 1));
  EXPECT_TRUE(huge->gets("HTTP/1.1 413"));
}

TEST_F(WebLimits, OneFileIsUploadedAtATimeAndHasMinutes) {
  serve();
  const auto first = client();
  first->send(upload_of(6) + "abc");
  world.settle();
  const auto second = client();
  second->send(upload_of(3) + "abc");
  EXPECT_TRUE(second->gets("HTTP/1.1 429"));
  world.pass(4min);
  first->send("def");
  EXPECT_TRUE(first->gets("HTTP/1.1 200"));
  const auto third = client();
  third->send(upload_of(6) + "abc");
  world.pass(5min);
  EXPECT_TRUE(third->gets("HTTP/1.1 408"));
  const auto fourth = client();
  fourth->send(upload_of(3) + "abc");
  EXPECT_TRUE(fourth->gets("HTTP/1.1 200"));
}

TEST_F(WebLimits, ABodyThatDoesNotComeIsGivenUp) {
  serve();
  const auto slow = client();
  slow->send("PUT /api/v1/a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nabc");
  world.pass(30s);
  EXPECT_TRUE(slow->gets("HTTP/1.1 408"));
  EXPECT_TRUE(slow->is_closed());
  EXPECT_TRUE(site.requests.empty());
}

TEST_F(WebLimits, AnAnswerThatIsNotTakenIsGivenUp) {
  serve();
  page.body = std::string(20'000'000, 'x');
  const auto slow = client();
  slow->hold(true);
  slow->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  world.pass(29s);
  EXPECT_EQ(server->connections(), 1U);
  world.pass(6s);
  EXPECT_EQ(server->connections(), 0U);
}

TEST_F(WebLimits, ASiteThatDoesNotAnswerEndsInA504) {
  serve();
  const auto program = client();
  program->send(kAskForever);
  ASSERT_TRUE(world.until([&] { return site.exchanges == 1; }));
  world.pass(10min);
  EXPECT_TRUE(program->gets("HTTP/1.1 504"));
  EXPECT_EQ(site.exchanges, 0);
  site.late({});  // too late: nothing happens
  world.settle();
}

TEST_F(WebLimits, AnAnswerMayComeLater) {
  serve();
  const auto program = client();
  program->send(kAskForever + kAsk);
  ASSERT_TRUE(world.until([&] { return site.exchanges == 1; }));
  site.late({.status = 202, .content_type = "text/plain", .body = "at last"});
  EXPECT_TRUE(program->gets("at last"));
  EXPECT_TRUE(program->gets("GET /api/v1/a")) << "the request behind it is answered after it";
  EXPECT_EQ(site.exchanges, 0);
}

TEST_F(WebLimits, OfIdleConnectionsTheOldestMakesRoom) {
  serve();
  std::deque<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 64; ++i) {
    idle.push_back(client());
    world.settle_briefly();
  }
  const auto browser = client();
  browser->send(kAsk);
  EXPECT_TRUE(browser->gets("/api/v1/a"));
  EXPECT_TRUE(idle.front()->is_closed());
  EXPECT_EQ(server->connections(), 64U);
  EXPECT_EQ(server->counters().turned_away, 0U);
}

TEST_F(WebLimits, WhereAllAreBusyMoreAreTurnedAway) {
  serve();
  std::deque<std::unique_ptr<RawClient>> busy;
  for (int i = 0; i < 64; ++i) {
    busy.push_back(client());
    busy.back()->send(kAskForever);
  }
  ASSERT_TRUE(world.until([&] { return site.exchanges == 64; }));
  const auto more = client();
  more->send(kAsk);
  EXPECT_TRUE(more->gets("HTTP/1.1 503"));
  EXPECT_TRUE(more->gets("too many connections are open"));
  EXPECT_TRUE(more->is_closed());
  EXPECT_EQ(site.exchanges, 64);
  EXPECT_TRUE(log.contains("64 connections are open"));
  busy.pop_front();
  site.late({});
  EXPECT_TRUE(world.until([&] { return site.exchanges < 64; }));
}

TEST_F(WebLimits, RefusalsAreBoundedToo) {
  serve();
  std::deque<std::unique_ptr<RawClient>> busy, more;
  for (int i = 0; i < 64; ++i) {
    busy.push_back(client());
    busy.back()->send(kAskForever);
  }
  ASSERT_TRUE(world.until([&] { return site.exchanges == 64; }));
  for (int i = 0; i < 20; ++i) more.push_back(client());
  ASSERT_TRUE(world.until([&] { return server->counters().turned_away == 20; }));
  world.settle();
  const auto answered = std::count_if(more.begin(), more.end(), [](const auto& one) { return !one->received.empty(); });
  EXPECT_EQ(answered, 8);
  world.pass(2s);
  const auto later = client();
  EXPECT_TRUE(later->gets("HTTP/1.1 503"));
}

TEST_F(WebLimits, OneAddressWithBegunRequestsDoesNotKeepOthersOut) {
  serve();
  std::deque<std::unique_ptr<RawClient>> slow;
  const auto begin_more = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      slow.push_back(client("127.0.0.2"));
      slow.back()->send("GET / HTTP/1.1\r\n");
      world.settle_briefly();
    }
    EXPECT_TRUE(world.until([&] { return server->counters().accepted >= slow.size(); }));
  };
  begin_more(64);
  const auto browser = client("127.0.0.3");
  browser->send(kAsk.substr(0, 10));
  ASSERT_TRUE(world.until([&] { return server->counters().accepted == 65; }));
  begin_more(70);
  browser->send(kAsk.substr(10));
  EXPECT_TRUE(browser->gets("200 OK"));
  EXPECT_EQ(server->connections(), 64U);
}

TEST_F(WebLimits, WebSocketsWithoutATokenMakeRoom) {
  access::AccessRules rules;
  rules.needs_token = true;
  serve(rules);
  std::deque<std::unique_ptr<RawClient>> unnamed;
  for (int i = 0; i < 64; ++i) {
    unnamed.push_back(client());
    unnamed.back()->send(kUpgrade);
  }
  ASSERT_TRUE(world.until([&] { return site.conversations == 64; }));
  const auto browser = client();
  browser->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_TRUE(browser->gets("200 OK"));
  EXPECT_EQ(site.conversations, 63);
}

TEST_F(WebLimits, TenThousandConnectionsCostSixtyFour) {
  serve();
  std::deque<std::unique_ptr<RawClient>> open;
  const auto working = client();
  working->send(kAskForever);
  ASSERT_TRUE(world.until([&] { return site.exchanges == 1; }));
  for (int i = 0; i < 10'000; ++i) {
    open.push_back(client());
    world.settle_briefly();
    ASSERT_LE(server->connections(), 64U);
    if (open.size() > 200) open.pop_front();
  }
  EXPECT_TRUE(world.until([&] { return server->counters().accepted == 10'001; }));
  const auto browser = client();
  browser->send(kAsk);
  EXPECT_TRUE(browser->gets("/api/v1/a"));
  EXPECT_EQ(site.exchanges, 1) << "who was being answered still is";
}

TEST_F(WebLimits, AServerThatEndsClosesEverything) {
  serve();
  const auto waiting = client(), reading = client(), streaming = client(), silent = client();
  waiting->send(kAskForever);
  reading->send(kUpgrade);
  streaming->send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(
      world.until([&] { return site.exchanges == 1 && site.conversations == 2 && server->connections() == 4; }));
  server.reset();
  EXPECT_EQ(site.exchanges, 0);
  EXPECT_EQ(site.conversations, 0);
  for (const auto& one : {waiting.get(), reading.get(), streaming.get(), silent.get()}) EXPECT_TRUE(one->is_closed());
}

TEST_F(WebLimits, ATakenPortIsSaid) {
  serve();
  auto second =
      Server::open({world.context, world.time, *access, site, page, Log(log, "web")}, {.listen = server->local()});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kBusy);
  EXPECT_THAT(second.error().text, HasSubstr("cannot listen on 127.0.0.1:"));
}

}  // namespace
}  // namespace rubicon::web::server
