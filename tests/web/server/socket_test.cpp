#include <gmock/gmock.h>

#include "web/server/frames.h"
#include "web/server/served.h"

namespace rubicon::web::server {
namespace {

using testing::HasSubstr;

class WebSockets : public ServedTest {
 protected:
  std::unique_ptr<RawClient> opened() {
    auto one = client();
    one->send(kUpgrade);
    EXPECT_TRUE(one->gets("\r\n\r\n"));
    EXPECT_TRUE(world.until([&] { return site.conversations == 1; }));
    one->received.clear();
    return one;
  }
  /// It takes nothing from now on, and more waits for it than the buffers of both ends take.
  void fill_the_line_to(RawClient& page) {
    page.hold(true);
    for (int i = 0; i < 200; ++i) {
      site.conversation->say(std::string(60000, 'x'));
      world.settle_briefly();
    }
  }
};

TEST_F(WebSockets, CarryTextBothWays) {
  serve();
  const auto page = opened();
  page->send(frame(kText, "echo"));
  ASSERT_TRUE(page->gets("echoed"));
  EXPECT_EQ(site.frames, std::vector<std::string>{"echo"});
  EXPECT_EQ(site.callers.at(0).name, "local");
  EXPECT_EQ(site.callers.at(0).peer, "127.0.0.1");
}

TEST_F(WebSockets, PutTheFragmentsOfAMessageTogether) {
  serve();
  const auto page = opened();
  page->send(frame(kText, "ec", false) + frame(kPing, "still there?") + frame(0, "ho"));
  ASSERT_TRUE(page->gets("echoed"));
  EXPECT_THAT(page->received, HasSubstr(std::string("\x8a\x0cstill there?")));
}

TEST_F(WebSockets, ALongFrameIsSentInOnePiece) {
  serve();
  const auto page = opened();
  site.conversation->say(std::string(60'000, 'x'));
  ASSERT_TRUE(world.until([&] { return page->received.size() >= 60'004; }));
  EXPECT_EQ(page->received.substr(0, 4), "\x81\x7e\xea\x60");
}

struct BrokenFrames {
  const char* name;
  std::string bytes;
  int code;
};

TEST_F(WebSockets, EndWithTheCodeOfWhatWasWrong) {
  const std::vector<BrokenFrames> cases{
      {"no mask", frame(kText, "echo", true, false), 1002},
      {"a reserved opcode", frame(3, "x"), 1002},
      {"reserved bits", "\xf1\x80" + std::string(4, '\0'), 1002},
      {"a continuation of nothing", frame(0, "x"), 1002},
      {"a long ping", frame(kPing, std::string(126, 'x')), 1002},
      {"a close of one byte", frame(kClose, "x"), 1002},
      {"text that is no UTF-8", frame(kText, "\xc3\x28"), 1007},
      {"half a character at the end", frame(kText, "\xe2\x82"), 1007},
      {"a surrogate", frame(kText, "\xed\xa0\x80"), 1007},
      {"bytes", frame(kBinary, "echo"), 1003},
      {"a message that is too long", frame(kText, std::string(65537, 'x')), 1009},
      {"a message that is too long in pieces",
       frame(kText, std::string(60000, 'x'), false) + frame(0, std::string(6000, 'x')), 1009},
      {"an orderly end", frame(kClose, close_code(1000)), 1000},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.name);
    serve();
    const auto page = opened();
    page->send(one.bytes);
    EXPECT_TRUE(page->gets(close_code(one.code)));
    world.pass(2s);  // some wait for the client's own close frame
    EXPECT_TRUE(page->is_closed());
    EXPECT_TRUE(world.until([&] { return site.conversations == 0 && server->connections() == 0; }));
    EXPECT_TRUE(site.frames.empty());
  }
}

TEST_F(WebSockets, HalfAFrameAndThenNothingIsNoMessage) {
  serve();
  auto page = opened();
  page->send(frame(kText, "echo").substr(0, 8));
  world.settle();
  page.reset();
  EXPECT_TRUE(world.until([&] { return server->connections() == 0; }));
  EXPECT_TRUE(site.frames.empty());
  EXPECT_EQ(site.conversations, 0);
}

TEST_F(WebSockets, AMessageOf64KiBIsTaken) {
  serve();
  const auto page = opened();
  page->send(frame(kText, std::string(65536, 'x')));
  ASSERT_TRUE(world.until([&] { return site.frames.size() == 1; }));
  EXPECT_EQ(site.frames.at(0).size(), 65536U);
}

TEST_F(WebSockets, TheSiteEndsThemWithAReason) {
  serve();
  const auto page = opened();
  page->send(frame(kText, "leave"));
  EXPECT_TRUE(page->gets(close_code(1008) + "as you like"));
  page->send(frame(kClose, close_code(1008)));
  EXPECT_TRUE(page->is_closed());
  EXPECT_EQ(site.conversations, 0);
}

TEST_F(WebSockets, AClientThatDoesNotAnswerTheEndIsClosed) {
  serve();
  const auto page = opened();
  page->send(frame(kText, "leave"));
  EXPECT_TRUE(page->gets("as you like"));
  world.pass(2s);
  EXPECT_TRUE(page->is_closed());
}

TEST_F(WebSockets, ProgramsGetPingsWhileNothingHappens) {
  serve();
  const auto program = opened();
  world.pass(20s);
  EXPECT_TRUE(program->gets(std::string("\x89\0", 2)));
}

TEST_F(WebSockets, ACompressedConversationIsOffered) {
  serve({}, {.listen = {}, .compress = true});
  const auto page = client();
  auto request = kUpgrade;
  request.insert(request.size() - 2, "Sec-WebSocket-Extensions: permessage-deflate\r\n");
  page->send(request);
  EXPECT_TRUE(page->gets("permessage-deflate"));
  serve();
  const auto plain = client();
  plain->send(request);
  EXPECT_TRUE(plain->gets("\r\n\r\n"));
  EXPECT_THAT(plain->received, testing::Not(HasSubstr("permessage-deflate")));
}

TEST_F(WebSockets, AClientThatReadsNothingCostsOneFrameAndIsClosed) {
  serve();
  const auto page = opened();
  page->hold(true);
  int said = 0;
  // Far more than the buffers of both ends take.
  for (int i = 0; i < 1000; ++i) {
    site.conversation->say(std::string(60000, 'x'));
    ++said;
    world.settle_briefly();
    if (site.conversation->asked + 3 < said) break;
  }
  EXPECT_LT(site.conversation->asked + 3, said) << "frames are asked for only while the client takes them";
  world.pass(29s);
  EXPECT_EQ(site.conversations, 1);
  world.pass(6s);
  EXPECT_EQ(site.conversations, 0);
  EXPECT_EQ(server->connections(), 0U);
}

TEST_F(WebSockets, ASlowReaderStaysAndGetsTheLastValue) {
  serve();
  const auto page = opened();
  fill_the_line_to(*page);
  world.pass(25s);
  page->hold(false);
  site.conversation->say("the last one");
  EXPECT_TRUE(page->gets("the last one"));
  world.pass(25s);
  EXPECT_EQ(site.conversations, 1);
}

TEST_F(WebSockets, RequestsAreNotReadWithoutBoundWhileTheClientTakesNothing) {
  serve();
  const auto page = opened();
  fill_the_line_to(*page);
  site.frames.clear();
  std::string flood;
  for (int i = 0; i < 1000; ++i) flood += frame(kText, "x");
  page->send(flood);
  world.settle();
  EXPECT_LE(site.frames.size(), Limits().ahead);
  page->hold(false);
  EXPECT_TRUE(world.until([&] { return site.frames.size() == 1000; })) << "none is lost";
}

}  // namespace
}  // namespace rubicon::web::server
