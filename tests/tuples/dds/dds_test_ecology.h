#pragma once

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/private_network.h"
#include "tuples/cuttable_link.h"
#include "tuples/dds/dds_ecology.h"

namespace rubicon::tuples::dds {

/// Components in one process and virtual time that reach each other by real DDS on loopback, in a network of this
/// process alone where it may have one. Nobody else's: each has a tag of its own.
class DdsTestEcology {
 public:
  explicit DdsTestEcology(VirtualScheduler& time, DdsOptions options = {}) : time_(time) {
    static const support::PrivateNetwork alone;
    static int count = 0;
    options.tag = "test-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
    options_ = options;
    auto opened = DdsEcology::open(
        options, time, [this](std::function<void()> call) { post(std::move(call)); }, log_,
        [this] { return time_.now().time_since_epoch(); });
    if (!opened) throw std::runtime_error(opened.error().text);
    ecology_ = std::move(*opened);
    ecology_->watch_displaced([this](OwnerId id) { displaced.push_back(id); });
    time_.ask_outside([this] { return take(); });
  }
  ~DdsTestEcology() { time_.ask_outside(nullptr); }
  DdsTestEcology(const DdsTestEcology&) = delete;
  DdsTestEcology& operator=(const DdsTestEcology&) = delete;

  Result<std::unique_ptr<Link>> join(OwnerId id) {
    auto link = ecology_->join(id);
    if (!link) return fail(link.error());
    return std::make_unique<CuttableLink>(std::move(*link), links_, id);
  }
  /// Components whose id another process has, and had before.
  std::vector<OwnerId> displaced;
  const support::CollectingLog& log() const { return log_; }
  std::vector<ComponentStart> component_starts() const { return ecology_->component_starts(); }
  const DdsOptions& options() const { return options_; }
  /// As after a change of an address.
  void enter_again() { ecology_->enter_again(); }
  bool expects_components() const { return ecology_->expects_components(); }

  void cut(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.cut(peer); });
  }
  void mend(OwnerId a, OwnerId b) {
    each(a, b, [](CuttableLink& link, OwnerId peer) { link.mend(peer); });
  }

 private:
  static constexpr auto kPatience = std::chrono::milliseconds(1);

  /// In a later turn, as everything that links tell.
  template <class Call>
  void each(OwnerId a, OwnerId b, Call call) {
    time_.post([this, a, b, call] {
      for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
        if (const auto found = links_.find(one); found != links_.end()) call(*found->second, other);
      }
    });
  }
  void post(std::function<void()> call) {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
    came_.notify_one();
  }
  bool take() {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, kPatience, [this] { return !calls_.empty(); });
    if (calls_.empty()) return false;
    for (auto& call : calls_) time_.post(std::move(call));
    calls_.clear();
    return true;
  }

  VirtualScheduler& time_;
  DdsOptions options_;
  support::CollectingLog log_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::function<void()>> calls_;
  std::map<OwnerId, CuttableLink*> links_;
  std::unique_ptr<DdsEcology> ecology_;
};

}  // namespace rubicon::tuples::dds
