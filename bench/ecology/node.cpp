#include "ecology/node.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace rubicon::bench {

namespace {

constexpr std::size_t kValueSize = 64;
constexpr Duration kPatience = std::chrono::seconds(30);

}  // namespace

void give_up(const std::string& why) {
  fmt::print(stderr, "rubicon-bench-ecology: {}\n", why);
  std::exit(1);
}

tuples::dds::DdsOptions options_of(const Meeting& meeting) {
  tuples::dds::DdsOptions options;
  options.domain = meeting.domain;
  options.tag = meeting.tag;
  return options;
}

Node::Node(OwnerId id, const Meeting& meeting) {
  const auto post = [this](std::function<void()> call) { loop_.scheduler().post(std::move(call)); };
  auto ecology = tuples::dds::DdsEcology::open(options_of(meeting), loop_.scheduler(), post, log_);
  if (!ecology) give_up(ecology.error().text);
  ecology_ = std::move(*ecology);
  auto link = ecology_->join(id);
  if (!link) give_up(link.error().text);
  link_ = std::move(*link);
  space_ = std::make_unique<tuples::TupleSpace>(id, loop_.scheduler(), *link_);
}

void Node::run(Duration most) {
  const auto late = scheduler().after(most, [] { give_up("a measurement does not come to its end"); });
  loop_.run();
}

void Node::await(OwnerId peer) {
  const auto peers = space().peers();
  if (std::find(peers.begin(), peers.end(), peer) != peers.end()) return;
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
