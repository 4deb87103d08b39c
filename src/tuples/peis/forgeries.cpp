#include "tuples/peis/forgeries.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "tuples/peis/own_messages.h"

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxDoubts = 64;
constexpr Duration kProofTime = std::chrono::seconds(3);  ///< for what came another way than its host's own

std::string refusal(const NodeLink& link, OwnerId source, std::string_view what) {
  return fmt::format("{} of component {} came from component {} at {}, which cannot say this: ignored", what,
                     number(source), number(link.peer), transport::to_string(link.connection->remote()));
}

}  // namespace

/// A neighbour says what it is on its own connection. Of a host further away, who is on the way can say anything, and
/// the ways there and back may differ.
bool Forgeries::speaks_for(const NodeLink& link, OwnerId source) const {
  if (link.peer == source) return link.is_route();
  const auto* route = routes_.find(source);
  return !route || !route->direct;
}

bool Forgeries::is_forged(const NodeLink& link, const Package& package) {
  const auto& header = package.header;
  if (header.routing == Routing::kLink) return false;
  if (header.routing == Routing::kDirect && header.destination != context_.options.id) return false;
  if (header.port == Port::kDeadHost) return is_forged_death(link, package);
  if (header.port != Port::kHello || package.body.empty() || speaks_for(link, header.source)) return false;
  // Not acknowledged: the true one is sent again, on the connection that there is by now.
  doubt(context_.counters.forged_hellos, link, header.source, "hello",
        [this, source = header.source, hello = decode_hello(package.body)] {
          const auto* host = hosts_.find(source);
          return !host || (hello && host->hello == *hello);
        });
  return true;
}

bool Forgeries::is_forged_death(const NodeLink& link, const Package& package) {
  const auto source = package.header.source;
  const auto dead = read_dead_host(package.body);
  if (!dead) return false;
  const auto* route = routes_.find(source);
  const bool is_by_its_way = link.peer == source || !route || route->link == link.id;
  const bool may = dead->id == context_.options.id || (dead->id == source && is_by_its_way);
  if (may && speaks_for(link, source)) return false;
  const auto* host = hosts_.find(source);
  if (dead->id != source) return refuse(context_.counters.forged_deaths, link, source, "DEAD_HOST"), true;
  if (!host) return true;  // it has left
  // A neighbour may pass on the goodbye before the host's own copy comes.
  doubt(context_.counters.forged_deaths, link, source, "DEAD_HOST", [this, source, magic = host->magic] {
    const auto* present = hosts_.find(source);
    return !present || present->magic != magic;
  });
  return true;
}

void Forgeries::refuse(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what) {
  ++counter;
  context_.log.warning(fmt::format("refused {}", what), refusal(link, source, what));
}

void Forgeries::doubt(std::uint64_t& counter, const NodeLink& link, OwnerId source, std::string_view what,
                      std::function<bool()> is_true) {
  if (doubts_.size() >= kMaxDoubts) return refuse(counter, link, source, what);
  const auto text = refusal(link, source, what);
  doubts_.push_back(
      {context_.scheduler.now() + kProofTime, std::move(is_true), [this, &counter, text, name = std::string(what)] {
         ++counter;
         context_.log.warning("refused " + name, text);
       }});
  if (doubts_.size() == 1) due_ = context_.scheduler.at(doubts_.front().due, [this] { judge(); });
}

void Forgeries::judge() {
  for (; !doubts_.empty() && doubts_.front().due <= context_.scheduler.now(); doubts_.pop_front()) {
    if (!doubts_.front().is_true()) doubts_.front().refuse();
  }
  if (!doubts_.empty()) due_ = context_.scheduler.at(doubts_.front().due, [this] { judge(); });
}

}  // namespace rubicon::tuples::peis
