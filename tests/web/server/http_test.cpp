#include "web/server/http_text.h"
#include "web/server/served.h"

namespace rubicon::web::server {
namespace {

using HttpServer = ServedTest;

TEST_F(HttpServer, AnswersARequestOfTheSiteAndKeepsTheConnection) {
  serve();
  auto browser = client();
  browser->send("GET /api/v1/a?x=1%202 HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(browser->gets("GET /api/v1/a"));
  browser->received.clear();
  browser->send("PUT /api/v1/b HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc");
  ASSERT_TRUE(browser->gets("PUT /api/v1/b"));
  EXPECT_EQ(site.requests[0].parameter("x"), "1 2");
  EXPECT_EQ(site.requests[0].caller.name, "local");
  EXPECT_EQ(site.requests[1].body, "abc");
}

TEST_F(HttpServer, CarriesAStreamOfEvents) {
  serve();
  auto program = client();
  program->send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(program->gets("Transfer-Encoding: chunked"));
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  site.conversation->say("data: 1\n\n");
  ASSERT_TRUE(program->gets("9\r\ndata: 1\n\n\r\n"));
  program->close();
  EXPECT_TRUE(world.until([&] { return site.conversations == 0; }));
}

TEST_F(HttpServer, TheSiteEndsAStreamWithItsLastChunk) {
  serve();
  auto program = client();
  program->send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  site.conversation->say("data: 1\n\n");
  ASSERT_TRUE(program->gets("data: 1"));
  site.conversation->calls.close("");
  EXPECT_TRUE(program->is_closed());
  EXPECT_TRUE(program->received.ends_with("0\r\n\r\n"));
  EXPECT_EQ(site.conversations, 0);
}

TEST_F(HttpServer, AStreamForHttp10HasNoChunks) {
  serve();
  auto program = client();
  program->send("GET /api/v1/stream HTTP/1.0\r\nHost: localhost\r\n\r\n");
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  site.conversation->say("data: 1\n\n");
  ASSERT_TRUE(program->gets("\r\n\r\ndata: 1\n\n"));
  EXPECT_EQ(program->received.find("chunked"), std::string::npos);
}

TEST_F(HttpServer, ALineOfAResponseThatWouldEndAFieldIsLeftOut) {
  const Response response{.content_type = "text/plain", .headers = {{"X", "a\r\nSet-Cookie: b"}, {"Y", "c"}}};
  const auto head = head_text(response, {}, {});
  EXPECT_EQ(head.find("Set-Cookie"), std::string::npos);
  EXPECT_NE(head.find("Y: c\r\n"), std::string::npos);
}

}  // namespace
}  // namespace rubicon::web::server
