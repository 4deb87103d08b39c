#include "components/node.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace rubicon::bench {

namespace {

constexpr std::size_t kValueSize = 64;
constexpr Duration kPatience = std::chrono::seconds(30);

}  // namespace

void give_up(const std::string& why) {
  fmt::print(stderr, "{}: {}\n", ::program_invocation_short_name, why);
  std::exit(1);
}

Node::Node(OwnerId id, const Meeting& meeting) {
  try {
    ecology_ = open_engine(meeting, loop_, log_);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  auto link = ecology_->join(id);
  if (!link) give_up(link.error().text);
  link_ = std::move(*link);
  space_ = std::make_unique<tuples::TupleSpace>(id, loop_.scheduler(), *link_);
}

void Node::run(Duration most) {
  const auto late = scheduler().after(most, [] { give_up("a measurement does not come to its end"); });
  loop_.run();
}

void Node::rest(Duration time) {
  const auto over = scheduler().after(time, [this] { finish(); });
  loop_.run();
}

void Node::await(OwnerId peer) {
  const auto peers = space().peers();
  if (std::find(peers.begin(), peers.end(), peer) != peers.end()) return;
  const auto named =
      awaits_by_name ? space().subscribe({peer, "bench.met"}, {}, [](const tuples::Event&) {}) : Handle();
  const auto watch = space().watch_peers([this, peer](OwnerId who, tuples::PeerEvent event) {
    if (who == peer && event == tuples::PeerEvent::kUp) finish();
  });
  run(kPatience);
}

void Node::await_end_of(OwnerId peer) {
  const auto watch = space().watch_peers([this, peer](OwnerId who, tuples::PeerEvent event) {
    if (who == peer && event != tuples::PeerEvent::kUp) finish();
  });
  run(std::chrono::minutes(5));
}

double seconds_between(SteadyTime from, SteadyTime to) {
  return std::chrono::duration<double>(to - from).count();
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double own_processor_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::string value_of(std::uint64_t number) {
  auto text = std::to_string(number);
  text.resize(kValueSize, ' ');
  return text;
}

std::uint64_t number_of(std::string_view value) {
  std::uint64_t number = 0;
  std::from_chars(value.data(), value.data() + value.size(), number);
  return number;
}

}  // namespace rubicon::bench
