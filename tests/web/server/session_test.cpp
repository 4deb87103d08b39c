#include <gmock/gmock.h>

#include "web/server/frames.h"
#include "web/server/served.h"

namespace rubicon::web::server {
namespace {

using testing::HasSubstr;

const std::string kStream = "GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// A server that wants tokens; `secret` is the one of a viewer.
class WebSessions : public ServedTest {
 protected:
  WebSessions() {
    access::AccessRules rules;
    rules.needs_token = true;
    serve(rules);
    access->take({{"viewer", Role::kView, access::sha256("secret")}});
  }
  std::string answer_to(const std::string& request) {
    const auto browser = client();
    browser->send(request);
    EXPECT_TRUE(browser->gets("\r\n\r\n"));
    world.settle();
    return browser->received;
  }
  std::string log_in(const std::string& more = {}) {
    const std::string body = "{\"token\":\"secret\"}";
    return answer_to("POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\n" + more +
                     "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }
  std::string with_cookie(const std::string& method, const std::string& path, const std::string& cookie) {
    return answer_to(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nCookie: a=b; " + cookie + "\r\n\r\n");
  }
  std::unique_ptr<RawClient> conversing(std::string request, const std::string& cookie) {
    request.insert(request.size() - 2, "Cookie: " + cookie + "\r\n");
    auto page = client();
    page->send(request);
    return page;
  }
  static std::string cookie_in(const std::string& answer) {
    const auto begin = answer.find("Set-Cookie: ");
    if (begin == answer.npos) return {};
    return answer.substr(begin + 12, answer.find(';', begin) - begin - 12);
  }
};

TEST_F(WebSessions, BeginWithATokenAndEndWithTheLogout) {
  const auto cookie = cookie_in(log_in());
  EXPECT_EQ(cookie.size(), std::string("rubicon=").size() + 32);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("200 OK"));
  EXPECT_EQ(site.requests.back().caller.name, "viewer");
  EXPECT_THAT(with_cookie("DELETE", "/api/v1/session", cookie), HasSubstr("204"));
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("401"));
}

TEST_F(WebSessions, AnIdThatWasThereBeforeTheLoginIsNeverUsed) {
  const std::string planted = "rubicon=00000000000000000000000000000000";
  const auto cookie = cookie_in(log_in("Cookie: " + planted + "\r\n"));
  EXPECT_NE(cookie, planted);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", planted), HasSubstr("401"));
}

TEST_F(WebSessions, ANewLoginEndsTheOneBefore) {
  const auto first = cookie_in(log_in());
  const auto second = cookie_in(log_in("Cookie: " + first + "\r\n"));
  EXPECT_NE(first, second);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", first), HasSubstr("401"));
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", second), HasSubstr("200"));
}

TEST_F(WebSessions, EndWhenTheTokenIsTakenAway) {
  const auto cookie = cookie_in(log_in());
  EXPECT_TRUE(access->take({}));
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("401"));
}

TEST_F(WebSessions, WhatWasOpenedWithATokenEndsWithIt) {
  const access::Token viewer{"viewer", Role::kView, access::sha256("secret")};
  EXPECT_FALSE(access->take({viewer, {"new", Role::kView, access::sha256("other")}})) << "one more";
  EXPECT_TRUE(access->take({viewer})) << "one less";
  EXPECT_TRUE(access->take({{"viewer", Role::kAdmin, viewer.hash}})) << "another role";
  const auto program = client();
  program->send(kUpgrade);
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  server->disconnect();
  EXPECT_EQ(site.conversations, 0);
  EXPECT_TRUE(program->is_closed());
  EXPECT_THAT(log_in(), HasSubstr("200 OK")) << "and the server goes on";
}

TEST_F(WebSessions, EndAfterTwelveHoursWithoutARequest) {
  const auto cookie = cookie_in(log_in());
  world.pass(11h);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("200"));
  world.pass(12h);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("401"));
}

TEST_F(WebSessions, GuessesAreCountedForEachAddress) {
  const std::string guess = "GET /api/v1/a HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer wrong\r\n\r\n";
  for (int i = 0; i < 5; ++i) EXPECT_THAT(answer_to(guess), HasSubstr("HTTP/1.1 401"));
  EXPECT_THAT(answer_to(guess), HasSubstr("HTTP/1.1 429"));
  EXPECT_THAT(log_in(), HasSubstr("HTTP/1.1 200")) << "wrong tokens do not lock out a right one from the same address";
  EXPECT_THAT(answer_to(guess), HasSubstr("HTTP/1.1 429"));
  world.pass(60s);
  EXPECT_THAT(answer_to(guess), HasSubstr("HTTP/1.1 401"));
}

TEST_F(WebSessions, EndWhenTheirTokenIsReplacedUnderItsName) {
  const auto cookie = cookie_in(log_in());
  EXPECT_TRUE(access->take({{"viewer", Role::kView, access::sha256("another")}}));
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("401"));
}

TEST_F(WebSessions, ALogoutEndsItsConversationsAndNoOthers) {
  const auto cookie = cookie_in(log_in()), other_cookie = cookie_in(log_in());
  const auto socket = conversing(kUpgrade, cookie), other = conversing(kUpgrade, other_cookie);
  const auto events = conversing(kStream, cookie);
  ASSERT_TRUE(world.until([&] { return site.conversations == 3; }));
  with_cookie("DELETE", "/api/v1/session", cookie);
  EXPECT_TRUE(socket->is_closed());
  EXPECT_TRUE(events->is_closed());
  EXPECT_EQ(site.conversations, 1);
  EXPECT_FALSE(other->closed);
}

TEST_F(WebSessions, AreUsedByAConversationThatGoesOnAndEndItAfterAWeek) {
  const auto cookie = cookie_in(log_in());
  const auto socket = conversing(kUpgrade, cookie);
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  world.pass(13h);
  EXPECT_EQ(site.conversations, 1);
  EXPECT_THAT(with_cookie("GET", "/api/v1/a", cookie), HasSubstr("200"));
  world.pass(168h);
  EXPECT_EQ(site.conversations, 0);
  EXPECT_TRUE(socket->is_closed());
}

TEST_F(WebSessions, AWebSocketWithoutOneIsOpenedForItsFirstFrame) {
  const auto program = client();
  program->send(kUpgrade);
  ASSERT_TRUE(world.until([&] { return site.callers.size() == 1; }));
  EXPECT_EQ(site.callers[0].role, Role::kNone);
  auto known = kUpgrade;
  known.insert(known.size() - 2, "Cookie: " + cookie_in(log_in()) + "\r\n");
  const auto page = client();
  page->send(known);
  ASSERT_TRUE(world.until([&] { return site.callers.size() == 2; }));
  EXPECT_EQ(site.callers[1].role, Role::kView);
}

}  // namespace
}  // namespace rubicon::web::server
