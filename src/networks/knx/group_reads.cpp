#include "networks/knx/group_reads.h"

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx {

namespace {

constexpr unsigned kTries = 2;
/// A question that cannot leave for so long is asked anew.
constexpr Duration kLifetime = std::chrono::seconds(30);

}  // namespace

GroupReads::GroupReads(Scheduler& scheduler, Options options, NoAnswer no_answer)
    : scheduler_(scheduler), options_(options), no_answer_(std::move(no_answer)) {}

/// What left before the line was lost is asked anew; what did not leave is still in the line.
void GroupReads::use(Line* line) {
  line_ = line;
  for (auto& [address, question] : open_) {
    question.patience.cancel();
    if (line_ == nullptr || question.under_way) continue;
    question.tries = 0;
    put(address);
  }
  fill();
}

void GroupReads::ask(GroupAddress address, bool first) {
  if (open_.contains(address)) return;
  if (queued_.insert(address).second) {
    (first ? urgent_ : others_).push_back(address);
  } else if (first) {
    const auto found = std::find(others_.begin(), others_.end(), address);
    if (found == others_.end()) return;
    others_.erase(found);
    urgent_.push_back(address);
  }
  fill();
}

void GroupReads::heard(GroupAddress address) {
  if (open_.erase(address) > 0) return fill();
  if (queued_.erase(address) == 0) return;
  std::erase(urgent_, address);
  std::erase(others_, address);
}

void GroupReads::clear() {
  urgent_.clear();
  others_.clear();
  queued_.clear();
  open_.clear();
}

std::size_t GroupReads::open(bool first) const {
  const auto same = [first](const auto& one) { return one.second.first == first; };
  return static_cast<std::size_t>(std::count_if(open_.begin(), open_.end(), same));
}

void GroupReads::fill() {
  for (const bool first : {true, false}) {
    auto& queue = first ? urgent_ : others_;
    const auto most = first ? options_.urgent : options_.open;
    while (line_ != nullptr && !queue.empty() && open(first) < most) {
      const auto address = queue.front();
      queue.pop_front();
      queued_.erase(address);
      open_[address].first = first;
      put(address);
    }
  }
}

void GroupReads::put(GroupAddress address) {
  ++asked_;
  auto& question = open_[address];
  ++question.tries;
  question.under_way = true;
  Telegram telegram;
  telegram.service = Service::kRead;
  telegram.destination = address;
  line_->send(std::move(telegram), scheduler_.now() + kLifetime,
              [this, address, alive = std::weak_ptr<bool>(alive_)](Sent, std::string_view) {
                if (alive.lock()) left(address);
              });
}

void GroupReads::left(GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  found->second.under_way = false;
  if (line_ == nullptr) return;
  found->second.patience = scheduler_.after(options_.patience, [this, address] { over(address); });
}

void GroupReads::over(GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  if (found->second.tries < kTries) return put(address);
  open_.erase(found);
  ++unanswered_;
  no_answer_(address);
  fill();
}

}  // namespace rubicon::networks::knx
