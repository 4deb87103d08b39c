// A chat between components, in a program that has an event loop of its own: 3_own_loop NAME
// Prints components that appear and leave. A line `ID TEXT` on standard input is sent to the component with that id.
// The end of the input, SIGINT or SIGTERM ends the program.
//
// The client is one more descriptor of the program's loop: whenever it is readable, poll() handles what is due. All
// runs on one thread.

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <iostream>
#include <rubicon/client.hpp>

namespace {

constexpr const char* kChat = "chat";  // content type of the messages

/// Readable after one of the signals.
int signals_descriptor() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigprocmask(SIG_BLOCK, &set, nullptr);
  return signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

std::string name_of(const rubicon::Client& client, rubicon::OwnerId id) {
  for (const auto& component : client.components()) {
    if (component.id == id) return component.summary.name;
  }
  return {};
}

/// One line of the user: `70001 hello`.
void send_line(rubicon::Client& client, std::string_view line) {
  std::uint32_t id = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), id);
  if (error != std::errc()) {
    std::cout << "expected: ID TEXT" << std::endl;
    return;
  }
  line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  if (line.starts_with(' ')) line.remove_prefix(1);
  client.send(rubicon::OwnerId(id), kChat, line, [id](const std::string& error) {
    std::cout << "to " << id << ": " << (error.empty() ? "accepted" : error) << std::endl;
  });
}

/// Reads what standard input has; false at its end.
bool read_input(rubicon::Client& client, std::string& pending) {
  std::array<char, 4096> buffer;
  const auto count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
  if (count <= 0) return false;
  pending.append(buffer.data(), static_cast<std::size_t>(count));
  for (auto end = pending.find('\n'); end != std::string::npos; end = pending.find('\n')) {
    send_line(client, std::string_view(pending).substr(0, end));
    pending.erase(0, end + 1);
  }
  return true;
}

void loop(rubicon::Client& client) {
  std::string pending;
  std::array<pollfd, 3> wanted{
      {{client.descriptor(), POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}, {signals_descriptor(), POLLIN, 0}}};
  while (true) {
    client.poll();  // cheap when nothing is due
    if (::poll(wanted.data(), wanted.size(), -1) < 0) continue;
    if (wanted[2].revents != 0) return;
    if (wanted[1].revents != 0 && !read_input(client, pending)) return;
  }
}

}  // namespace

int main(int argc, char** argv) {
  rubicon::client::Options options;
  options.name = argc > 1 ? argv[1] : "anonymous";
  auto opened = rubicon::Client::open(options);
  if (!opened) {
    std::cerr << opened.error().text << '\n';
    return 1;
  }
  rubicon::Client& client = **opened;
  std::cout << "I am " << number(client.id()) << std::endl;

  const auto presence = client.tuples().watch_peers([&](rubicon::OwnerId id, rubicon::PeerEvent event) {
    if (event != rubicon::PeerEvent::kUp)
      std::cout << (event == rubicon::PeerEvent::kLeft ? "left " : "lost ") << number(id) << std::endl;
  });
  const auto names = client.tuples().watch_summaries([&](rubicon::OwnerId id, std::string_view) {
    std::cout << "present " << number(id) << ' ' << name_of(client, id) << std::endl;
  });
  const auto letters = client.on_message(kChat, [](const rubicon::client::UserMessage& message) {
    std::cout << "from " << number(message.from) << ": " << message.bytes << std::endl;
  });
  loop(client);
}
