#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <regex>
#include <thread>

#include "ecology/trust_lan.h"
#include "support/terminal.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using support::Terminal;

/// What a person does with two hosts, at two terminals.
class TheFirstMinute : public TrustOnALan {
 protected:
  /// In long runs with the pauses of a person, 200 characters a minute.
  static void type_slowly(const Terminal& terminal, const std::string& text) {
    for (const char key : text) {
      terminal.type(std::string(1, key));
      std::this_thread::sleep_for(pause());
    }
    terminal.type("\n");
  }
  static std::chrono::milliseconds pause() { return std::getenv("RUBICON_CHAOS_SECONDS") == nullptr ? 20ms : 300ms; }

  /// A shell on a host, with `rubicon` on its path, and this folder as that of the host or of the person.
  std::unique_ptr<Terminal> shell_on(int host, const std::string& trust) const {
    const Host::Visit visit(lan_.host(host));
    auto shell =
        std::make_unique<Terminal>(std::vector<std::string>{"env", "PS1=$ ", "RUBICON_TRUST=" + trust,
                                                            "PATH=" RUBICON_BINARY_DIR "/bin:/usr/bin:/bin", "sh", "-c",
                                                            "cd " + folder_.string() + " && exec sh -i"},
                                   40, 200);
    EXPECT_TRUE(shell->shows("$")) << shell->text();
    return shell;
  }
};

TEST_F(TheFirstMinute, FromInitToALampThatAPersonOnAnotherHostCommands) {
  const auto begin = std::chrono::steady_clock::now();
  const auto there = shell_on(0, "trust"), here = shell_on(1, "desk");
  type_slowly(*there, "rubicon trust dds init");
  ASSERT_TRUE(there->shows("fingerprint ")) << there->text();
  start_island();
  type_slowly(*there, "rubicon trust dds add desk --role admin");
  ASSERT_TRUE(there->shows("phrase  ")) << there->text();
  std::smatch phrase;
  const auto shown = there->text();
  ASSERT_TRUE(std::regex_search(shown, phrase, std::regex("phrase +([a-z0-9-]+)"))) << shown;
  type_slowly(*here, "rubicon trust dds join desk.trust");
  ASSERT_TRUE(here->shows("[y/N]")) << here->text();
  type_slowly(*here, "y");
  ASSERT_TRUE(here->shows("phrase:")) << here->text();
  type_slowly(*here, phrase[1]);
  ASSERT_TRUE(here->shows("joined ")) << here->text();
  type_slowly(*here, "rubicon set den.switch-1 on --interfaces cable");
  ASSERT_TRUE(here->shows("proxy.dummy-1.den.actuator.switch-1")) << here->text() << island_->errors();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  RecordProperty("seconds", std::to_string(seconds.count()));
  EXPECT_EQ(local({"get", kLampValue}).output, "on\n") << island_->errors();
}

}  // namespace
}  // namespace rubicon::ecology
