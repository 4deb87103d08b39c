#include "networks/knx/group_reads.h"

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
void GroupReads::use(line::Line* line) {
  line_ = line;
  for (auto& [address, question] : open_) {
    question.patience.cancel();
    if (line_ == nullptr || question.under_way) continue;
    question.tries = 0;
    put(address);
  }
  fill();
}

void GroupReads::ask(wire::GroupAddress address, Rank rank) {
  if (open_.contains(address)) return;
  const auto [waiting, fresh] = ranks_.emplace(address, rank);
  if (!fresh && waiting->second <= rank) return;
  waiting->second = rank;
  queues_[static_cast<std::size_t>(rank)].push_back(address);
  fill();
}

void GroupReads::heard(wire::GroupAddress address) {
  ranks_.erase(address);
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  --open_count_[static_cast<std::size_t>(found->second.rank)];
  open_.erase(found);
  fill();
}

void GroupReads::keep(const std::function<bool(wire::GroupAddress)>& wanted) {
  std::erase_if(ranks_, [&](const auto& one) { return !wanted(one.first); });
  std::erase_if(open_, [&](const auto& one) {
    const bool goes = !wanted(one.first);
    if (goes) --open_count_[static_cast<std::size_t>(one.second.rank)];
    return goes;
  });
  fill();
}

void GroupReads::fill() {
  for (std::size_t rank = 0; rank < kRanks; ++rank) {
    auto& queue = queues_[rank];
    while (line_ != nullptr && !queue.empty() && open_count_[rank] < options_.open[rank]) {
      const auto address = queue.front();
      queue.pop_front();
      const auto waiting = ranks_.find(address);
      if (waiting == ranks_.end() || static_cast<std::size_t>(waiting->second) != rank) continue;
      ranks_.erase(waiting);
      ++open_count_[rank];
      open_[address].rank = static_cast<Rank>(rank);
      put(address);
    }
  }
}

void GroupReads::put(wire::GroupAddress address) {
  ++asked_;
  auto& question = open_[address];
  ++question.tries;
  question.under_way = true;
  wire::Telegram telegram;
  telegram.service = wire::Service::kRead;
  telegram.destination = address;
  line_->send(std::move(telegram), scheduler_.now() + kLifetime,
              [this, address, alive = std::weak_ptr<bool>(alive_)](line::SendOutcome, std::string_view) {
                if (alive.lock()) left(address);
              });
}

void GroupReads::left(wire::GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  found->second.under_way = false;
  if (line_ == nullptr) return;
  found->second.patience = scheduler_.after(options_.patience, [this, address] { over(address); });
}

void GroupReads::over(wire::GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  if (found->second.tries < kTries) return put(address);
  --open_count_[static_cast<std::size_t>(found->second.rank)];
  open_.erase(found);
  ++unanswered_;
  no_answer_(address);
  fill();
}

}  // namespace rubicon::networks::knx
