#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "web/server/certificate.h"
#include "web/server/served.h"
#include "web/server/tls_client.h"

namespace rubicon::web::server {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kAskSecurely = "GET /api/v1/a HTTP/1.1\r\nHost: localhost\r\n\r\n";

class TlsServer : public ServedTest {
 protected:
  TlsServer() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~TlsServer() override { fs::remove_all(folder_); }

  /// The clock of the test stands at 2026-01-01.
  std::time_t in(Duration span) { return std::chrono::system_clock::to_time_t(world.time.wall_now() + span); }
  void serve_tls(Duration valid = 24h * 365) {
    serve({}, {.listen = {}, .tls = write_certificate(path_, 1, in(valid))});
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "rubicon_web_tls";
  std::string path_ = (folder_ / "web").string();
};

TEST_F(TlsServer, AnswersByTls) {
  serve_tls();
  TlsClient browser(world, server->local());
  ASSERT_TRUE(browser.shakes_hands());
  EXPECT_TRUE(browser.gets(kAskSecurely, "GET /api/v1/a"));
  EXPECT_TRUE(server->secure());
}

TEST_F(TlsServer, CarriesABodyAndAnAnswerOfAMegabyte) {
  serve_tls();
  page.body = std::string(1 << 20, 'x') + "the end";
  TlsClient browser(world, server->local());
  ASSERT_TRUE(browser.shakes_hands());
  EXPECT_TRUE(browser.gets("PUT /api/v1/a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1048576\r\n\r\n" +
                               std::string(1 << 20, 'b') + "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
                           "the end"));
  EXPECT_EQ(site.requests.at(0).body.size(), std::size_t{1} << 20);
}

TEST_F(TlsServer, ItsOriginIsHttps) {
  serve_tls();
  TlsClient browser(world, server->local());
  ASSERT_TRUE(browser.shakes_hands());
  EXPECT_TRUE(browser.gets("DELETE /api/v1/a HTTP/1.1\r\nHost: localhost\r\nOrigin: http://localhost\r\n\r\n", "403"));
}

TEST_F(TlsServer, SpeaksNothingOlderThanTls12) {
  serve_tls();
  TlsClient old(world, server->local(), TLS1_1_VERSION);
  EXPECT_FALSE(old.shakes_hands());
  TlsClient fair(world, server->local(), TLS1_2_VERSION);
  EXPECT_TRUE(fair.shakes_hands());
}

TEST_F(TlsServer, AClientWithoutTlsIsToldToUseHttps) {
  serve_tls();
  const auto plain = client();
  plain->send(kAskSecurely);
  EXPECT_TRUE(plain->is_closed());
  EXPECT_THAT(plain->received, testing::StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(plain->received, HasSubstr("this port speaks HTTPS: expected https:// in front of the address"));
  EXPECT_TRUE(site.requests.empty());
}

TEST_F(TlsServer, OnlyOverTlsBrowsersAreToldToComeBackByTls) {
  serve_tls();
  TlsClient browser(world, server->local());
  ASSERT_TRUE(browser.shakes_hands());
  EXPECT_TRUE(browser.gets(kAskSecurely, "\r\nStrict-Transport-Security: max-age=2592000\r\n"));
  const auto told = client();
  told->send(kAskSecurely);
  EXPECT_TRUE(told->is_closed());
  EXPECT_THAT(told->received, testing::Not(HasSubstr("Strict-Transport-Security"))) << "RFC 6797, section 7.2";
}

TEST_F(TlsServer, AStreamTellsThemToo) {
  serve_tls();
  TlsClient program(world, server->local());
  ASSERT_TRUE(program.shakes_hands());
  EXPECT_TRUE(program.gets("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n",
                           "\r\nStrict-Transport-Security: max-age=2592000\r\n"));
}

TEST_F(TlsServer, AHandshakeThatDoesNotEndIsGivenUp) {
  serve_tls();
  const auto silent = client();
  silent->send(std::string("\x16\x03\x01\x02\x00\x01", 6));
  world.pass(9s);
  EXPECT_EQ(server->connections(), 1U);
  world.pass(1s);
  EXPECT_TRUE(silent->is_closed());
}

TEST_F(TlsServer, ReadsItsCertificateAgainWithoutClosingConnections) {
  serve_tls();
  TlsClient before(world, server->local());
  ASSERT_TRUE(before.shakes_hands());
  EXPECT_EQ(before.serial(), 1);
  write_certificate(path_, 2, in(24h * 365));
  ASSERT_TRUE(server->reload());
  TlsClient after(world, server->local());
  ASSERT_TRUE(after.shakes_hands());
  EXPECT_EQ(after.serial(), 2);
  EXPECT_TRUE(before.gets(kAskSecurely, "GET /api/v1/a"));
}

TEST_F(TlsServer, KeepsTheCertificateWhereTheNewOneIsWrong) {
  serve_tls();
  std::ofstream(path_ + ".key") << "not a key";
  const auto read = server->reload();
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().text, HasSubstr("key " + path_ + ".key: "));
  TlsClient browser(world, server->local());
  EXPECT_TRUE(browser.shakes_hands());
}

TEST_F(TlsServer, ACertificateThatExpiresWhileItRunsIsSaidAndCanBeReplaced) {
  serve_tls(24h * 20);
  EXPECT_TRUE(log.lines.empty());
  world.pass(24h * 7);
  EXPECT_TRUE(log.contains("expires in 312 h")) << testing::PrintToString(log.lines);
  world.pass(24h * 14);
  EXPECT_TRUE(log.contains("has expired"));
  TlsClient careless(world, server->local());
  EXPECT_TRUE(careless.shakes_hands()) << "the client decides";
  write_certificate(path_, 2, in(24h * 365));
  ASSERT_TRUE(server->reload());
  log.lines.clear();
  world.pass(24h * 30);
  EXPECT_TRUE(log.lines.empty());
}

TEST_F(TlsServer, WithoutItsFilesNothingListens) {
  const auto files = write_certificate(path_, 1, in(24h));
  const auto open = [&](const TlsFiles& tls) {
    access.emplace(world.time, access::AccessRules{});
    auto opened = Server::open({world.context, world.time, *access, site, page, Log(log, "web")},
                               {.listen = {"127.0.0.1", 0}, .tls = tls});
    return opened ? std::string() : opened.error().text;
  };
  EXPECT_THAT(open({path_ + ".none", files.key}), HasSubstr("web.none: cannot read: No such file"));
  EXPECT_THAT(open({files.certificate, path_ + ".none"}), HasSubstr("key " + path_ + ".none: cannot read"));
  EXPECT_THAT(open({files.key, files.key}), HasSubstr("certificate " + files.key));
  const auto other = write_certificate(path_ + "-other", 2, in(24h));
  EXPECT_THAT(open({files.certificate, other.key}), HasSubstr("key values mismatch"));
}

}  // namespace
}  // namespace rubicon::web::server
