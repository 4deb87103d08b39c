#include "tuples/dds/trust/member/honest.h"

#include <algorithm>
#include <iostream>
#include <numeric>
#include <sstream>

#include "tuples/peer_policy.h"

namespace rubicon::tuples::dds {

namespace {

OwnerId id_of(const std::string& word) {
  return OwnerId(static_cast<std::uint32_t>(std::stoul(word)));
}

}  // namespace

Words words_of(const std::string& line) {
  std::istringstream in(line);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

void KeptLog::write(base::LogLevel, std::string_view, std::string_view text) {
  lines.emplace_back(text);
  std::cerr << text << std::endl;
}

Result<void> Honest::start(OwnerId id, Duration lease) {
  const auto judge = Judged::open_judge();
  DdsOptions options;
  options.tag = "trust";
  options.lease = lease;
  options.trust = trust_;
  if (trust_) options.judge = judge;
  auto opened = DdsEcology::open(
      options, loop_, [this](std::function<void()> call) { loop_.post(std::move(call)); }, log_);
  if (!opened) return fail(opened.error());
  ecology_ = std::move(*opened);
  auto link = ecology_->join(id);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  space_ = std::make_unique<TupleSpace>(id, loop_, *link_);
  judged_ = std::make_unique<Judged>(*space_, judge);
  copies_ = space_->subscribe(*Pattern::parse("a.**"), {}, [](const Event&) {});
  peers_ = space_->watch_peers([this](OwnerId, PeerEvent event) { losses_ += event != PeerEvent::kUp; });
  policy_ = space_->add_policy(*Pattern::parse("cmd"), [this](const RemoteSet& set) {
    ++executed_[std::string(set.value)];
    return SetDecision::applied();
  });
  return {};
}

/// One command a millisecond.
void Honest::send(OwnerId to, int count, int begun) {
  if (begun == count) return;
  ++sent_;
  space_->set_remote(to, "cmd", std::to_string(sent_), std::chrono::seconds(10), [this](const Reply& reply) {
    ++answered_;
    applied_ += reply.verdict == Verdict::kApplied;
  });
  sending_ = loop_.after(std::chrono::milliseconds(1), [=, this] { send(to, count, begun + 1); });
}

/// A second component of this process, with a tuple `a.other`.
void Honest::add_component(OwnerId id) {
  auto link = ecology_->join(id);
  if (!link) return void(std::cout << "other " << link.error().text << std::endl);
  other_link_ = std::move(*link);
  other_space_ = std::make_unique<TupleSpace>(id, loop_, *other_link_);
  std::ignore = other_space_->set("a.other", "5");
  std::cout << "other is there" << std::endl;
}

void Honest::obey(const Words& words) {
  judged_->obey(words);
  const auto& verb = words.at(0);
  if (verb == "set") std::ignore = space_->set(words.at(1), words.at(2));
  if (verb == "send") send(id_of(words.at(1)), std::stoi(words.at(2)), 0);
  if (verb == "renew") trust_->replace_papers();
  if (verb == "lay") trust_->lay_revoked(words.at(1));
  if (verb == "renew" || verb == "reload") {
    const auto done = ecology_->renew();
    std::cout << verb << ' ' << (done ? "done" : done.error().text) << std::endl;
  }
  if (verb == "revoke") trust_->find_revoked(words.at(1));
  if (verb == "end-in" || verb == "ends-in")
    trust_->end_at(loop_.wall_now() + std::chrono::milliseconds(std::stoi(words.at(1))));
  if (verb == "end-in") trust_->replace_papers();
  if (verb == "end-in") std::cout << "renewed " << ecology_->renew().has_value() << std::endl;
  if (verb == "see") {
    trust_->see(words.at(1) == "others");
    std::cout << "sees " << words.at(1) << std::endl;
  }
  if (verb == "peers") {
    std::cout << "peers";
    for (const auto id : space_->peers()) std::cout << ' ' << number(id);
    std::cout << std::endl;
  }
  if (verb == "other") add_component(id_of(words.at(1)));
  if (verb == "lists") std::cout << "lists " << trust_->lists_checked() << std::endl;
  if (verb == "losses") std::cout << "losses " << losses_ << std::endl;
  if (verb == "replies") std::cout << "replies " << applied_ << " of " << sent_ << std::endl;
  if (verb == "executed") {
    const auto doubled =
        std::count_if(executed_.begin(), executed_.end(), [](const auto& one) { return one.second > 1; });
    std::cout << "executed " << executed_.size() << " doubled " << doubled << std::endl;
  }
  if (verb == "incarnation") {
    for (const auto& one : ecology_->component_starts()) {
      if (one.id == id_of(words.at(1)) && one.present) std::cout << "incarnation " << one.incarnation << std::endl;
    }
  }
  if (verb == "claims") {
    link_->each_counter([](std::string_view name, std::uint64_t value) {
      if (name == "dds-false-claims") std::cout << "claims " << value << std::endl;
    });
  }
  if (verb == "refused") {
    link_->each_counter([](std::string_view name, std::uint64_t value) {
      if (name == "dds-refused-peers") std::cout << "refused " << value << std::endl;
    });
  }
}

bool Honest::holds(const Words& words) const {
  const auto& what = words.at(0);
  if (what == "alone") return space_->peers().empty();
  if (what == "revoked") return trust_->revoked() == words.at(1);
  if (what == "answered") return answered_ >= std::stoi(words.at(1));
  if (what == "peer") {
    const auto* member = link_->policy().member(id_of(words.at(1)));
    const auto peers = space_->peers();
    const bool there = std::find(peers.begin(), peers.end(), id_of(words.at(1))) != peers.end();
    return there && (words.size() < 3 || (member && member->name == words.at(2)));
  }
  if (what == "value") {
    const auto tuple = space_->get(id_of(words.at(1)), words.at(2));
    return tuple && tuple->value == words.at(3);
  }
  const auto text = std::accumulate(std::next(words.begin(), 2), words.end(), words.at(1),
                                    [](const auto& left, const auto& right) { return left + " " + right; });
  return what == "log" && std::any_of(log_.lines.begin(), log_.lines.end(),
                                      [&text](const auto& line) { return line.find(text) != line.npos; });
}

}  // namespace rubicon::tuples::dds
