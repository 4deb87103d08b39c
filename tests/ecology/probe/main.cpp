// A minimal component, for tests that need many: ecology-probe ID TUPLES, where TUPLES is the value of `tuples:` in a
// configuration. Prints its peers as JSON lines, and executes commands of the shell (docs/shell.md) until its input
// ends. All components may set its `probe.**`.

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "apps/program/process.h"
#include "config/engine_config.h"
#include "config/yaml.h"
#include "console/console.h"
#include "console/shell.h"
#include "rubicon/tuple_space.hpp"
#include "transport/asio_scheduler.h"
#include "transport/interfaces.h"
#include "transport/machine_sockets.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/link.h"

namespace rubicon {
namespace {

class Probe {
 public:
  Probe(OwnerId id, tuples::Ecology& ecology, transport::Loop& loop)
      : loop_(loop), output_(loop.context(), STDOUT_FILENO, [&loop] { loop.stop(); }) {
    auto link = ecology.join(id);
    if (!link) {
      fail_with(link.error());
      return;
    }
    link_ = std::move(*link);
    space_ = std::make_unique<TupleSpace>(id, loop.scheduler(), *link_);
    anybody_ =
        space_->add_policy({id, "probe.**"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); });
    peers_ = space_->watch_peers([this](OwnerId peer, tuples::PeerEvent event) { tell(peer, event); });
    shell_ = std::make_unique<console::Shell>(
        loop.scheduler(), *space_, id, "probe", [this](std::string line) { output_.answer(std::move(line)); },
        [this](std::string line) { output_.event(std::move(line)); }, [this] { loop_.stop(); });
    console::ConsoleReader::Callbacks calls;
    calls.line = [this](std::string_view line) { shell_->line(line); };
    calls.too_long = [this] { shell_->line_too_long(); };
    calls.pause = [this] { return output_.crowded(); };
    calls.end = [this] { loop_.stop(); };
    input_ = std::make_unique<console::ConsoleReader>(loop.context(), STDIN_FILENO, console::Shell::kMaxLine,
                                                      std::move(calls));
    output_.answer(R"({"ready":true})");
  }

 private:
  void fail_with(const Error& error) {
    fmt::print(stderr, "{}\n", error.text);
    loop_.stop();
  }

  void tell(OwnerId peer, tuples::PeerEvent event) {
    const auto* word = event == tuples::PeerEvent::kUp ? "up" : event == tuples::PeerEvent::kLeft ? "left" : "lost";
    output_.answer(fmt::format(R"({{"peer":{},"event":"{}","there":{}}})", number(peer), word, space_->peers().size()));
  }

  transport::Loop& loop_;
  console::ConsoleWriter output_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<TupleSpace> space_;
  std::unique_ptr<console::Shell> shell_;
  tuples::Handle anybody_, peers_;
  std::unique_ptr<console::ConsoleReader> input_;
};

int run(OwnerId id, const std::string& text) {
  const auto tree = config::parse_yaml("tuples: " + text + "\n", "tuples");
  base::ConfigErrors errors;
  if (!tree) return fmt::print(stderr, "{}\n", tree.error().text), 2;
  ConfigReader root(*tree, "", errors);
  const auto engine = config::read_engine(root, {});
  if (!errors.empty()) return fmt::print(stderr, "{}\n", errors.text()), 2;
  program::SpdlogSink log("warning");
  transport::Loop loop;
  const auto post = [&loop](std::function<void()> call) { loop.scheduler().post(std::move(call)); };
  auto ecology = tuples::dds::DdsEcology::open(engine.options, loop.scheduler(), post, log);
  if (!ecology) return fmt::print(stderr, "{}\n", ecology.error().text), 1;
  (*ecology)->follow(transport::netlink_interfaces(transport::asio_watch(loop)));
  const Probe probe(id, **ecology, loop);
  loop.run();
  return 0;
}

}  // namespace
}  // namespace rubicon

int main(int argc, char** argv) {
  if (argc != 3) return 1;
  return rubicon::run(rubicon::OwnerId(static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10))), argv[2]);
}
