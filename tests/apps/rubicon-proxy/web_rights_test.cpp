#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/text.h"
#include "support/folder.h"
#include "support/http_text.h"
#include "support/private_network.h"
#include "support/process.h"
#include "support/programs.h"

namespace rubicon::daemon {

using namespace support;

namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// printf secret | sha256sum
const std::string kHash = "2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b";
const std::string kBearer = "Authorization: Bearer secret\r\n";
constexpr const char* kLampTuple = "proxy.dummy-1.den.actuator.switch-1.command";

/// The island program with rights, and its page on loopback.
class PageWithRights : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string text_in(const std::string& name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::string configure(const std::string& web) const {
    write("home.yaml", "island: {id: 1, name: home}\nweb: {listen: \"127.0.0.1:0\"" + web +
                           "}\naudit: {file: home.audit}\nnetworks:\n"
                           "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}}}}}\n"
                           "rights:\n  - {who: tablet, may: [read, set], keys: [\"proxy.**\"]}\n"
                           "  - {who: everybody, may: read, keys: [\"proxy.networks\"]}\n");
    return folder_ / "home.yaml";
  }
  void start(const std::string& web) {
    program_ = std::make_unique<Process>(std::vector<std::string>{kDaemon, "run", configure(web), "--shell"});
    program_->write("stats\n");
    std::ignore = program_->line_with("\"ok\"");
  }
  int port() {
    const std::string mark = "web: open http";
    for (int i = 0; i < 6000; ++i, std::this_thread::sleep_for(10ms)) {
      const auto errors = program_->errors();
      const auto at = errors.find(mark);
      const auto end = at == errors.npos ? at : errors.find('\n', at);
      if (end == errors.npos) continue;
      const auto colon = errors.rfind(':', end);
      return base::parse_number<int>(errors.substr(colon + 1, end - colon - 1)).value_or(0);
    }
    return 0;
  }
  static std::string put(int port, const std::string& value, const std::string& fields) {
    return http_text(port, std::string("PUT /api/v1/tuples/1/") + kLampTuple,
                     fields + "Content-Length: " + std::to_string(value.size()) + "\r\n\r\n" + value);
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::unique_ptr<Process> program_;
};

TEST_F(PageWithRights, ACallerOfThisHostNeedsATokenAndIsAuditedUnderItsName) {
  write("web.tokens", "tablet:command:" + kHash + "\n");
  start(", tokens: {file: web.tokens}");
  const auto port = this->port();
  ASSERT_GT(port, 0) << program_->errors();
  EXPECT_THAT(put(port, "on", ""), HasSubstr("401"));
  EXPECT_THAT(put(port, "on", "Authorization: Bearer wrong\r\n"),
              AllOf(HasSubstr("HTTP/1.1 4"), Not(HasSubstr("applied"))));
  EXPECT_EQ(text_in("home.audit"), "");
  const auto done = put(port, "on", kBearer);
  EXPECT_THAT(done, HasSubstr("200 OK")) << program_->errors();
  const auto refused = http_text(port, "PUT /api/v1/tuples/1/proxy.inbox.command", kBearer + "Content-Length: 0\r\n");
  EXPECT_THAT(refused, HasSubstr("403"));
  const auto audit = text_in("home.audit");
  const auto first = nlohmann::json::parse(audit.substr(0, audit.find('\n')), nullptr, false);
  EXPECT_EQ(first.value("who", ""), "tablet") << audit;
  EXPECT_EQ(first.value("key", ""), kLampTuple);
  EXPECT_EQ(first.value("value", ""), "on");
  EXPECT_EQ(first.value("verdict", ""), "accepted");
  EXPECT_EQ(first.value("host", ""), "127.0.0.1");
  EXPECT_EQ(std::count(audit.begin(), audit.end(), '\n'), 2) << audit;
  EXPECT_THAT(program_->errors() + audit, Not(HasSubstr("secret")));
}

TEST_F(PageWithRights, WithoutTokensThereIsNoPage) {
  start("");
  const auto errors = program_->errors();
  EXPECT_THAT(errors, AllOf(HasSubstr("with rights each caller needs a token"), HasSubstr("runs without its page"),
                            Not(HasSubstr("open http"))));
}

TEST_F(PageWithRights, ATokenWhoseNameMeansOthersIsRefusedInTheConfiguration) {
  for (const std::string name : {"peis", "lan", "everybody"}) {
    write("web.tokens", name + ":admin:" + kHash + "\n");
    const auto file = configure(", tokens: {file: web.tokens}");
    const auto checked = run_to_end({kDaemon, "check", file});
    EXPECT_EQ(checked.code, 2) << name;
    EXPECT_THAT(checked.errors, AllOf(HasSubstr("home.yaml:2:"), HasSubstr("web.tokens"),
                                      HasSubstr("line 1: '" + name + "' is not a name of a token")));
    start(", tokens: {file: web.tokens}");
    EXPECT_THAT(program_->errors(), AllOf(HasSubstr("'" + name + "' is not a name of a token"),
                                          HasSubstr("runs without its page"), Not(HasSubstr("open http"))));
  }
}

}  // namespace
}  // namespace rubicon::daemon
