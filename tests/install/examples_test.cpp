#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <sstream>

#include "install/installed.h"
#include "support/private_network.h"

namespace rubicon::install {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kWatch = RUBICON_BINARY_DIR "/bin/example-1_watch";
const std::string kCommand = RUBICON_BINARY_DIR "/bin/example-2_command";

/// The examples of examples/client beside a real daemon, in a network of their own.
class Examples : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    ASSERT_EQ(all_.outcome().code, 0) << all_.outcome().output << all_.outcome().errors;
    write_text(file_, sample_island(7));
  }
  std::vector<std::string> island() const {
    return {all_.daemon(), "run", file_.string(), "--shell", "--log-level", "error"};
  }
  /// The third example, built outside the tree against what was installed; empty (and a failure) if that fails.
  std::string own_loop() const {
    const auto source = (all_.prefix() / "share/doc/rubicon/examples/client/3_own_loop").string();
    const auto build = (all_.workshop() / "own_loop").string();
    const auto built =
        all_.shell(RUBICON_CMAKE " -S " + source + " -B " + build + " -DCMAKE_PREFIX_PATH=" + all_.prefix().string() +
                   " -DCMAKE_CXX_COMPILER=" RUBICON_CXX " -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror " +
                   RUBICON_SANITIZER_FLAGS "' && " RUBICON_CMAKE " --build " + build);
    EXPECT_EQ(built.code, 0) << built.output;
    return built.code == 0 ? build + "/own_loop" : std::string();
  }

  const Installed& all_ = Installed::get();
  const std::filesystem::path file_ = all_.workshop() / "examples.yaml";
  support::PrivateNetwork alone_;
};

TEST_F(Examples, TheFirstShowsValuesAsTheyCome) {
  Process watch({kWatch, "temperature"});  // before the island is there
  Process home(island());
  for (int value = 0; value < 3; ++value) {
    EXPECT_THAT(watch.line_with("value").value_or("nothing"),
                StartsWith("7:proxy.dummy-1.hall.sensor.temperature-1.value"));
  }
  watch.signal(SIGINT);
  EXPECT_EQ(watch.exit_code(), 0) << watch.errors();
}

TEST_F(Examples, TheSecondCommandsAndSaysHowItEnded) {
  Process home(island());
  home.write("stats\n");
  ASSERT_TRUE(home.line_with("\"ok\"")) << home.errors();
  const auto on = support::run_to_end({kCommand, "lamp", "on", "Hall"});
  EXPECT_EQ(on.output, "Hall, proxy.dummy-1.hall.actuator.lamp-1.command: confirmed\n") << on.errors;
  EXPECT_EQ(on.code, 0);
  const auto maybe = support::run_to_end({kCommand, "lamp", "maybe"});
  EXPECT_THAT(maybe.output, HasSubstr(": refused ("));
  EXPECT_EQ(maybe.code, 3);
  EXPECT_EQ(support::run_to_end({kCommand, "boiler", "on"}).code, 4);
}

/// `I am 70001` -> `70001`.
std::string own_id(Process& chat) {
  const auto line = chat.line_with("I am ");
  return line ? line->substr(5) : std::string();
}

TEST_F(Examples, TheThirdIsBuiltOutsideTheTreeAndTalksInItsOwnLoop) {
  const auto program = own_loop();
  ASSERT_NE(program, "");
  Process ann({program, "Ann"});
  const auto ann_id = own_id(ann);
  ASSERT_NE(ann_id, "");
  {
    Process home(island());
    EXPECT_TRUE(ann.line_with("present 7 home"));
    Process bob({program, "Bob"});
    const auto bob_id = own_id(bob);
    ASSERT_TRUE(ann.line_with("present " + bob_id + " Bob"));
    ASSERT_TRUE(bob.line_with("present " + ann_id + " Ann"));
    for (int letter = 0; letter < 20; ++letter) bob.write(ann_id + " letter " + std::to_string(letter) + "\n");
    for (int letter = 0; letter < 20; ++letter)  // once each, in order
      EXPECT_EQ(ann.line_with("from ").value_or("nothing"), "from " + bob_id + ": letter " + std::to_string(letter));
    EXPECT_TRUE(bob.line_with("to " + ann_id + ": accepted"));
    ann.write("7 hello\n");  // nobody of the island wants letters
    EXPECT_THAT(ann.line_with("to 7: ").value_or("nothing"), HasSubstr("island 7 has no listener"));
    bob.close_input();
    EXPECT_TRUE(ann.line_with("left " + bob_id));
    EXPECT_EQ(bob.exit_code(), 0) << bob.errors();
    home.signal(SIGKILL);
    EXPECT_TRUE(ann.line_with("lost 7"));
  }
  ann.signal(SIGTERM);
  EXPECT_EQ(ann.exit_code(), 0) << ann.errors();
}

}  // namespace
}  // namespace rubicon::install
