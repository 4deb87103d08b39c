#include "networks/knx/group_reads.h"

#include <utility>

namespace rubicon::networks::knx {

namespace {

constexpr unsigned kMaxReadAttempts = 2;
/// A read that cannot be sent for this long expires and is repeated.
constexpr Duration kLifetime = std::chrono::seconds(30);

}  // namespace

GroupReads::GroupReads(Scheduler& scheduler, Options options, NoAnswer no_answer)
    : scheduler_(scheduler), options_(options), no_answer_(std::move(no_answer)) {}

/// Reads that were sent before the line was lost are repeated; the others are still in the line.
void GroupReads::use(line::Line* line) {
  line_ = line;
  for (auto& [address, read] : open_) {
    read.timeout.cancel();
    if (line_ == nullptr || read.queued) continue;
    read.attempts = 0;
    put(address);
  }
  fill();
}

void GroupReads::add(wire::GroupAddress address, Rank rank) {
  if (open_.contains(address)) return;
  const auto [waiting, fresh] = ranks_.emplace(address, rank);
  if (!fresh && waiting->second <= rank) return;
  waiting->second = rank;
  queues_[static_cast<std::size_t>(rank)].push_back(address);
  fill();
}

void GroupReads::received(wire::GroupAddress address) {
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
  ++sent_;
  auto& read = open_[address];
  ++read.attempts;
  read.queued = true;
  wire::Telegram telegram;
  telegram.service = wire::Service::kRead;
  telegram.destination = address;
  line_->send(std::move(telegram), scheduler_.now() + kLifetime,
              [this, address, watch = lifetime_.watch()](line::SendOutcome outcome, std::string_view why) {
                if (watch.ended()) return;
                outcome == line::SendOutcome::kRefused ? give_up(address, why) : sent(address);
              });
}

void GroupReads::sent(wire::GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  found->second.queued = false;
  if (line_ == nullptr) return;
  found->second.timeout = scheduler_.after(options_.answer_time, [this, address] { timed_out(address); });
}

void GroupReads::timed_out(wire::GroupAddress address) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  if (found->second.attempts < kMaxReadAttempts) return put(address);
  give_up(address, {});
}

void GroupReads::give_up(wire::GroupAddress address, std::string_view why) {
  const auto found = open_.find(address);
  if (found == open_.end()) return;
  --open_count_[static_cast<std::size_t>(found->second.rank)];
  open_.erase(found);
  ++unanswered_;
  no_answer_(address, why);
  fill();
}

}  // namespace rubicon::networks::knx
