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

TEST_F(HttpServer, CarriesAWebSocket) {
  serve();
  auto browser = client();
  browser->send(
      "GET /api/v1/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  ASSERT_TRUE(browser->gets("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
  ASSERT_TRUE(world.until([&] { return site.conversations == 1; }));
  site.conversation->say("{\"alive\":1}");
  ASSERT_TRUE(browser->gets(std::string("\x81\x0b{\"alive\":1}")));
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

}  // namespace
}  // namespace rubicon::web::server
