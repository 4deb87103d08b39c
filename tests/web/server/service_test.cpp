#include <gmock/gmock.h>

#include <deque>
#include <filesystem>
#include <fstream>

#include "support/memory/memory_transports.h"
#include "support/rights.h"
#include "tuples/memory/memory_ecology.h"
#include "web/server/certificate.h"
#include "web/server/frames.h"
#include "web/server/served.h"
#include "web/server/tls_client.h"
#include "web/web_service.h"

namespace rubicon::web {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// The whole service, by TLS and with tokens.
class SecureService : public testing::Test {
 protected:
  SecureService() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    certificate(1);
    allow("first");
    setup_.listen = {"127.0.0.1", 0};
    setup_.tls = config::WebTls{"web.pem", "web.key"};
    setup_.tokens = "web.tokens";
    open();
  }
  ~SecureService() override {
    service_.reset();
    fs::remove_all(folder_);
  }

  void open() {
    auto opened =
        WebService::open({world_.context, world_.time, space_, files_, log_}, setup_, folder_.string(), "hall");
    ASSERT_TRUE(opened) << opened.error().text;
    service_ = std::move(*opened);
  }
  void certificate(long serial) {
    const auto valid = world_.time.wall_now() + 24h * 365;
    server::write_certificate((folder_ / "web").string(), serial, std::chrono::system_clock::to_time_t(valid));
  }
  void break_certificate() { std::ofstream(folder_ / "web.pem") << "nothing"; }
  /// The token that is the only one after the next reload.
  void allow(const std::string& token) {
    const auto digest = access::sha256(token);
    const auto line = "viewer:view:" + access::hex(digest.data(), digest.size()) + "\n";
    files_.put((folder_ / "web.tokens").string(), line);
  }
  /// The status of the answer to a caller with this token, and the serial number of the certificate.
  std::pair<std::string, long> ask(const std::string& token) {
    const auto address = service_->address();
    const auto port = std::stoi(address.substr(address.rfind(':') + 1));
    auto& client = clients_.emplace_back(world_, transport::Endpoint{"127.0.0.1", static_cast<std::uint16_t>(port)});
    EXPECT_TRUE(client.shakes_hands());
    EXPECT_TRUE(client.gets(
        "GET /api/v1/islands HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + token + "\r\n\r\n", "\r\n\r\n"));
    return {client.received.substr(9, 3), client.serial()};
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "rubicon_web_service";
  server::WebWorld world_;
  support::CollectingLog log_;
  transport::MemoryTransports files_;
  tuples::MemoryEcology ecology_{world_.time};
  std::unique_ptr<tuples::Link> link_ = ecology_.join(OwnerId(65536)).value();
  TupleSpace space_{OwnerId(65536), world_.time, *link_};
  config::WebSetup setup_;
  std::unique_ptr<WebService> service_;
  std::deque<server::TlsClient> clients_;
};

using Answer = std::pair<std::string, long>;

TEST_F(SecureService, AReloadTakesNewTokensAndTheNewCertificate) {
  EXPECT_EQ(ask("first"), Answer("200", 1));
  allow("second");
  certificate(2);
  ASSERT_TRUE(service_->reload());
  EXPECT_EQ(ask("first"), Answer("401", 2));
  EXPECT_EQ(ask("second"), Answer("200", 2));
}

TEST_F(SecureService, AReloadTakesBothOrNeither) {
  allow("second");
  break_certificate();
  EXPECT_FALSE(service_->reload());
  EXPECT_EQ(ask("first"), Answer("200", 1));
  EXPECT_EQ(ask("second"), Answer("401", 1));
  certificate(2);
  files_.put((folder_ / "web.tokens").string(), "?");
  EXPECT_FALSE(service_->reload());
  EXPECT_EQ(ask("first"), Answer("200", 1));
}

TEST_F(SecureService, AWrongTokenInTheHelloClosesTheWebSocketWithItsCode) {
  service_.reset();
  setup_.tls.reset();
  open();
  const auto address = service_->address();
  const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  server::RawClient program(world_, {"127.0.0.1", port});
  program.send(server::kUpgrade);
  ASSERT_TRUE(program.gets("101 Switching Protocols")) << program.received;
  program.send(server::frame(server::kText, R"({"id":1,"do":"hello","token":"guess"})"));
  EXPECT_TRUE(program.gets(server::close_code(1008) + "the token was not accepted")) << program.received;
}

/// A feed was opened by rights that the reload may have taken away.
TEST_F(SecureService, AReloadThatFailsEndsTheFeedsOfAJudgedIslandToo) {
  service_.reset();
  setup_.tls.reset();
  tuples::MemoryEcology judged{world_.time};
  judged.judge(OwnerId(65537), support::judge_of({}, nullptr));
  const auto link = judged.join(OwnerId(65537)).value();
  TupleSpace space(OwnerId(65537), world_.time, *link);
  auto opened = WebService::open({world_.context, world_.time, space, files_, log_}, setup_, folder_.string(), "hall");
  ASSERT_TRUE(opened) << opened.error().text;
  const auto address = (*opened)->address();
  const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  server::RawClient feed(world_, {"127.0.0.1", port});
  feed.send(
      "GET /api/v1/tuples?pattern=*:** HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer first\r\n"
      "Accept: text/event-stream\r\n\r\n");
  ASSERT_TRUE(feed.gets("text/event-stream")) << feed.received;
  files_.put((folder_ / "web.tokens").string(), "?");
  EXPECT_FALSE((*opened)->reload());
  EXPECT_TRUE(world_.until([&] { return feed.closed; }));
}

TEST_F(SecureService, TheMetricsHaveTheValuesOfTheSetup) {
  service_.reset();
  setup_.metrics = {{std::nullopt, "own.*"}};
  setup_.tokens.reset();
  setup_.tls.reset();
  open();
  ASSERT_TRUE(space_.set("own.load", "7"));
  const auto address = service_->address();
  const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  server::RawClient program(world_, {"127.0.0.1", port});
  program.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_TRUE(world_.until([&] {
    world_.time.run_for(100ms);
    return program.received.find("\r\n\r\n") != std::string::npos;
  }));
  EXPECT_TRUE(program.gets("rubicon_value{island=\"65536\",key=\"own.load\"} 7")) << program.received;
}

TEST_F(SecureService, AFileOfTokensWithoutANameOpensNothing) {
  service_.reset();
  setup_.tokens = "";
  const auto opened =
      WebService::open({world_.context, world_.time, space_, files_, log_}, setup_, folder_.string(), "");
  EXPECT_FALSE(opened);
}

}  // namespace
}  // namespace rubicon::web
