// A component that executes commands from standard input, one per line, and answers each with one line of JSON. Tests
// stop, continue, kill and disconnect it.
#include <poll.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "rubicon/client.hpp"

namespace {

using namespace std::chrono_literals;
using namespace rubicon;
using nlohmann::json;
using Words = std::vector<std::string>;

OwnerId owner_of(const std::string& word) {
  return OwnerId(static_cast<std::uint32_t>(std::stoul(word)));
}

class Member {
 public:
  explicit Member(Client& client) : client_(client), space_(client.tuples()) {
    watch_ = space_.watch_demand(*Pattern::parse("**"), [this](const tuples::Demand& demand) {
      demand.wanted ? void(wanted_.emplace(demand.key)) : void(wanted_.erase(std::string(demand.key)));
    });
    policy_ = space_.add_policy({client.id(), "cmd.**"}, [this](const tuples::RemoteSet& request) {
      note(commands_, request.from, request.value);
      return tuples::SetDecision::applied();
    });
    messages_ = client.on_message(
        "count", [this](const client::UserMessage& message) { note(heard_, message.from, message.bytes); });
  }

  json obey(const Words& words) {
    const auto& verb = words.at(0);
    if (verb == "set") return {{"ok", space_.set(words.at(1), words.at(2)).has_value()}};
    if (verb == "erase") return {{"ok", space_.erase(words.at(1)).has_value()}};
    if (verb == "sub") return subscribe(words);
    if (verb == "unsub") return {{"ok", subscriptions_.erase(words.at(1)) > 0}};
    if (verb == "wanted") return {{"ok", true}, {"wanted", wanted_}};
    if (verb == "copies") return copies();
    if (verb == "peers") return peers();
    if (verb == "command") return many(words, &Member::command);
    if (verb == "send") return many(words, &Member::send);
    if (verb == "answers") return {{"ok", true}, {"answers", answers_}};
    if (verb == "commands") return heard(commands_, words);
    if (verb == "heard") return heard(heard_, words);
    if (verb == "churn") return churn(std::stoi(words.at(1)));
    return {{"ok", false}, {"error", "no such command: " + verb}};
  }

 private:
  /// Messages from a sender that counts: 0, 1, 2, ...
  struct Count {
    int next = 0, disordered = 0;
  };
  using Counts = std::map<OwnerId, Count>;

  static void note(Counts& counts, OwnerId from, std::string_view text) {
    int number = -1;
    std::from_chars(text.data(), text.data() + text.size(), number);
    auto& count = counts[from];
    count.disordered += number != count.next;
    count.next = number + 1;
  }
  static json heard(const Counts& counts, const Words& words) {
    const auto found = counts.find(owner_of(words.at(1)));
    const auto count = found == counts.end() ? Count{} : found->second;
    return {{"ok", true}, {"count", count.next}, {"disordered", count.disordered}};
  }

  json subscribe(const Words& words) {
    const auto pattern = Pattern::parse(words.at(2));
    if (!pattern) return {{"ok", false}, {"error", pattern.error().text}};
    const Flow flow{{}, {}, 0, words.size() > 3};
    subscriptions_[words.at(1)] = space_.subscribe(*pattern, flow, [](const Event&) {});
    return {{"ok", true}};
  }

  json copies() {
    json found = json::object();
    space_.list(*Pattern::parse("**"), [&](const TupleView& tuple) {
      if (tuple.owner == client_.id()) return;
      found[std::to_string(number(tuple.owner)) + ":" + std::string(tuple.key)] =
          std::string(tuple.value) + (tuple.owner_present ? "" : " (absent)");
    });
    return {{"ok", true}, {"copies", found}};
  }

  json peers() {
    json found = json::array();
    for (const auto id : space_.peers()) found.push_back(number(id));
    return {{"ok", true}, {"peers", found}};
  }

  /// `command OWNER N`, `send OWNER N`: sends the next N numbers.
  json many(const Words& words, void (Member::*one)(OwnerId, const std::string&)) {
    const auto to = owner_of(words.at(1));
    for (int i = 0; i < std::stoi(words.at(2)); ++i) (this->*one)(to, std::to_string(sent_++));
    return {{"ok", true}};
  }
  void command(OwnerId to, const std::string& value) {
    space_.set_remote(to, "cmd.x", value, 60s,
                      [this](const Reply& reply) { ++answers_[std::string(to_string(reply.verdict))]; });
  }
  void send(OwnerId to, const std::string& bytes) {
    client_.send(to, "count", bytes, [this](const std::string& why_not) { ++answers_[why_not]; });
  }

  /// Subscribes and unsubscribes a thousand times a second.
  json churn(int cycles) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < cycles; ++i) {
      const auto brief = space_.subscribe({std::nullopt, "t.k" + std::to_string(i % 20)}, {}, [](const Event&) {});
      client_.run_until([&] { return std::chrono::steady_clock::now() >= start + i * 1ms; }, 1s);
    }
    const auto took = std::chrono::steady_clock::now() - start;
    return {{"ok", true}, {"per_second", cycles / std::chrono::duration<double>(took).count()}};
  }

  Client& client_;
  TupleSpace& space_;
  Handle watch_, policy_, messages_;
  std::map<std::string, Handle> subscriptions_;
  std::set<std::string> wanted_;
  std::map<std::string, int> answers_;
  Counts commands_, heard_;
  int sent_ = 0;
};

/// Reads the available input without waiting; false at its end.
bool read_lines(std::string& pending, std::vector<Words>& lines) {
  std::array<char, 4096> buffer{};
  const auto count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
  if (count <= 0) return false;
  pending.append(buffer.data(), static_cast<std::size_t>(count));
  for (auto end = pending.find('\n'); end != std::string::npos; end = pending.find('\n')) {
    std::istringstream line(pending.substr(0, end));
    pending.erase(0, end + 1);
    Words words{std::istream_iterator<std::string>(line), {}};
    if (!words.empty()) lines.push_back(std::move(words));
  }
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  client::Options options;
  if (count > 1) options.id = owner_of(arguments[1]);
  if (count > 2 && std::string_view(arguments[2]) == "dds") options.engines = {client::Engine::kDds};
  options.lease = 1s;
  auto client = Client::open(options);
  if (!client) {
    std::cerr << client.error().text << "\n";
    return 1;
  }
  Member member(**client);
  std::string pending;
  // A program with an event loop of its own: waits for standard input and for the client.
  std::array<pollfd, 2> files{{{STDIN_FILENO, POLLIN, 0}, {(*client)->descriptor(), POLLIN, 0}}};
  while (::poll(files.data(), files.size(), -1) > 0) {
    (*client)->poll();
    std::vector<Words> lines;
    if (files[0].revents != 0 && !read_lines(pending, lines)) break;
    for (const auto& words : lines) std::cout << member.obey(words) << std::endl;
  }
}
