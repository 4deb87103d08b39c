#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <limits>
#include <stop_token>
#include <thread>

#include "ecology/trust_lan.h"
#include "tuples/dds/rogue.h"

namespace rubicon::ecology {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;
using tuples::dds::Rogue;

/// A closed island on loopback, and a user of its host who is not in the group of the people.
class AnotherUserOfTheHost : public TrustOnALan {
 protected:
  void SetUp() override {
    TrustOnALan::SetUp();
    if (IsSkipped()) return;
    if (nobody({"--version"}).code != 0) GTEST_SKIP() << "needs root, setpriv, and programs that nobody may run";
    configure("audit: {file: home.audit}\n", "lease: 500ms");
    make_realm();
    fs::create_directory(file("nobody"));
    ASSERT_EQ(::chown(file("nobody").c_str(), 65534, 65534), 0);
    start_island();
    ASSERT_EQ(local_on_loopback({"set", kLampCommand, "on"}).code, 0) << island_->errors();
  }
  /// `rubicon` as that user.
  Outcome nobody(const std::vector<std::string>& words) const { return run(as_nobody(kToolProgram, words)); }
  std::vector<std::string> as_nobody(const std::string& program, const std::vector<std::string>& words) const {
    std::vector<std::string> all{"setpriv", "--reuid=65534",          "--regid=65534",      "--clear-groups",
                                 "env",     "HOME=" + file("nobody"), "RUBICON_ENGINE=dds", program};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  Outcome local_on_loopback(const std::vector<std::string>& words) const {
    std::vector<std::string> all{kToolProgram};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--engine", "dds", "--trust", file("trust")});
    return run(std::move(all));
  }
  Outcome run(std::vector<std::string> words) const {
    const Host::Visit visit(lan_.host(0));
    return support::run_to_end(std::move(words));
  }
  /// It is there, answers, and has the value and the lines in its audit that `local` gave it.
  void expect_untouched() {
    const auto value = local_on_loopback({"get", kLampValue});
    EXPECT_EQ(value.output, "on\n") << value.errors << island_->errors();
    EXPECT_THAT(island_->errors(), AllOf(Not(HasSubstr("in use by another process")), Not(HasSubstr("nobody"))));
    const auto audit = text_in("home.audit");
    EXPECT_THAT(audit, HasSubstr("\"who\":\"local\""));
    EXPECT_EQ(audit.find('\n'), audit.size() - 1) << audit;
  }
};

TEST_F(AnotherUserOfTheHost, NeitherReadsNorSets) {
  for (const auto& how : std::vector<std::vector<std::string>>{{"--trust", "no"}, {"--trust", file("trust")}, {}}) {
    for (auto words : std::vector<std::vector<std::string>>{{"get", kLampValue},
                                                            {"set", kLampCommand, "off"},
                                                            {"set", "1:proxy.settings.command", "reload"},
                                                            {"send", "den", "x"}}) {
      words.insert(words.end(), how.begin(), how.end());
      const auto refused = nobody(words);
      EXPECT_NE(refused.code, 0) << words[0] << refused.output;
      EXPECT_THAT(refused.output, Not(HasSubstr("on\n"))) << words[0];
    }
  }
  const auto told = nobody({"get", kLampValue, "--trust", file("trust")});
  EXPECT_EQ(told.code, 1);
  EXPECT_THAT(told.errors, AllOf(HasSubstr("members/local/key.pem: "), HasSubstr("`sudo adduser nobody rubicon`")));
  const auto islands = nobody({"islands", "--trust", "no"});
  EXPECT_THAT(islands.output, Not(HasSubstr("home"))) << islands.errors;
  expect_untouched();
}

TEST_F(AnotherUserOfTheHost, DoesNotTakePartByAFolderOfItsOwn) {
  const auto own = file("nobody/trust");
  ASSERT_EQ(nobody({"trust", "dds", "init", "--trust", own}).code, 0);
  EXPECT_EQ(nobody({"get", kLampValue, "--trust", own}).code, 8);
  // What all may read of the realm, and a key of its own.
  for (const auto* name : {"identity-ca.pem", "permissions-ca.pem", "governance.p7s", "revoked.p7s",
                           "members/local/certificate.pem", "members/local/permissions.p7s"}) {
    const auto copied = run(as_nobody("cp", {file("trust/") + name, own + "/" + name}));
    ASSERT_EQ(copied.code, 0) << copied.errors;
  }
  const auto refused = nobody({"set", kLampCommand, "off", "--trust", own});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("is not the key of CN=local"));
  expect_untouched();
}

TEST_F(AnotherUserOfTheHost, CannotChangeWhoIsAMember) {
  for (const auto& words : std::vector<std::vector<std::string>>{{"add", "thief", "--here"},
                                                                 {"revoke", "island-1"},
                                                                 {"renew", "local"},
                                                                 {"export", "local", "--out", file("nobody/x")},
                                                                 {"audit", "--config", file("home.yaml")}}) {
    auto all = words;
    if (words[0] != "audit") all.insert(all.begin(), "dds");
    all.insert(all.begin(), "trust");
    all.insert(all.end(), {"--trust", file("trust")});
    const auto refused = nobody(all);
    EXPECT_NE(refused.code, 0) << words[0] << refused.output;
    EXPECT_THAT(refused.output, Not(HasSubstr("local"))) << words[0];
  }
  expect_untouched();
}

TEST_F(AnotherUserOfTheHost, DoesNotDisplaceTheIslandByOneWithItsNumber) {
  write("nobody/home.yaml", "island: {id: 1, name: thief}\ntuples: {host: no, engine: dds, lease: 500ms}\n");
  ASSERT_EQ(::chown(file("nobody/home.yaml").c_str(), 65534, 65534), 0);
  const auto thief = start(0, as_nobody(kDaemonProgram, {"run", file("nobody/home.yaml"), "--shell"}));
  thief->write("stats\n");
  ASSERT_TRUE(thief->line_with("\"ok\"")) << thief->errors();
  expect_untouched();
}

TEST_F(AnotherUserOfTheHost, DoesNotKeepTheIslandFromItsMembersByAFlood) {
  std::jthread flood([&](const std::stop_token& stop) {
    const Host::Visit visit(lan_.host(0));
    Rogue rogue(66666);
    for (std::uint64_t start = 1; !stop.stop_requested(); ++start) rogue.show(1, start);
  });
  for (int i = 0; i < 10; ++i) {
    const auto commanded = local_on_loopback({"set", kLampCommand, i % 2 == 0 ? "off" : "on"});
    EXPECT_EQ(commanded.code, 0) << i << commanded.errors << island_->errors();
  }
  const auto value = local_on_loopback({"get", kLampValue});
  EXPECT_EQ(value.output, "on\n") << value.errors << island_->errors();
}

/// One sample like that ends an island without trust, also one from an older start.
TEST_F(AnotherUserOfTheHost, DoesNotDisplaceTheIslandByAPresence) {
  {
    const Host::Visit visit(lan_.host(0));
    Rogue rogue(66666);
    EXPECT_EQ(rogue.incarnation_of(1), 0U) << "the presence of the island is encrypted";
    for (const std::uint64_t start : {std::uint64_t{1}, rogue.incarnation(), std::numeric_limits<std::uint64_t>::max()})
      rogue.show(1, start);
    expect_untouched();
  }
  expect_untouched();
}

}  // namespace
}  // namespace rubicon::ecology
