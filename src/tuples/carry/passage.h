#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tuples/carry/engine_side.h"
#include "tuples/link.h"

namespace rubicon::tuples::carry {

/// What one component reads from one owner on another engine. The stand-in of the reader subscribes there; the stand-in
/// of the owner publishes the changes here. It starts closed: the stand-in of the reader may come later.
class Passage {
 public:
  static constexpr std::size_t kMaxSubscriptions = 10'000;
  /// Changes that wait for the reader. Beyond them all are dropped, and the owner is asked for a snapshot.
  static constexpr std::size_t kMaxWaiting = 100'000, kMaxWaitingBytes = 32 * 1024 * 1024;

  /// `to_reader` is the owner's stand-in, which outlives it; `keys`: the patterns that are carried.
  Passage(OwnerId owner, OwnerId reader, StandInPort& to_reader, std::vector<std::string> keys)
      : owner_(owner), reader_(reader), to_reader_(to_reader), keys_(std::move(keys)) {}

  /// False: beyond the bound, or a pattern that is none.
  bool subscribe(const SubscriptionSpec& spec);
  void unsubscribe(std::uint32_t id);
  /// Engine of the owner, where the reader needs a stand-in.
  std::size_t origin() const { return to_reader_.origin; }
  bool is_used() const { return subscriptions_.size() > subscriptions_.count(kObserver); }
  /// From now on the link of the owner's stand-in gets all that is carried (kLinkItself).
  void observe();

  /// `reader` is the stand-in of the reader; it lives until close().
  void open(StandInPort& reader);
  /// With `withdraw` the subscriptions end at the owner; else the stand-in is ending anyway.
  void close(bool withdraw);

  void on_changes(std::span<const Change> changes);
  /// Sends what waits. False: the reader accepts no more at the moment.
  bool flush();
  std::size_t waiting() const { return waiting_.size(); }

 private:
  static constexpr std::uint32_t kObserver = 0;  ///< no reader has this subscription

  struct Subscription {
    SubscriptionSpec spec;
    std::vector<std::string> keys;
    std::map<std::uint32_t, std::string> wires;               ///< as the owner knows them
    std::set<std::uint32_t> awaited;                          ///< those whose snapshot has not ended
    std::map<std::string, std::uint32_t, std::less<>> woken;  ///< by key: those of wake()
  };

  std::vector<std::string> carried(std::string_view pattern) const;
  void send(Subscription& subscription);
  void end_if_empty(const Subscription& subscription);
  void withdraw(Subscription& subscription);
  void restart(const Change& change);
  void end_snapshot(std::uint32_t wire);
  bool is_carried(std::string_view key) const;
  bool may_read(std::string_view key) const;
  Flow allowed(Flow flow, const std::string& keys) const;
  void wake(std::string_view key);
  void let_sleep(Subscription& subscription, std::string_view key);
  void let_all_sleep(Subscription& subscription);
  void on_carried(const Change& change, std::string_view key);
  bool is_read(std::string_view key) const;
  void show_to_link(const Change& change, std::string_view key);
  void end_observed_snapshot();
  void enqueue(const Change& change);
  void drop_waiting();
  bool ask_again();

  OwnerId owner_, reader_;
  StandInPort& to_reader_;
  std::vector<std::string> keys_;
  StandInPort* to_owner_ = nullptr;
  std::map<std::uint32_t, Subscription> subscriptions_;  ///< by id of the reader
  std::map<std::uint32_t, std::uint32_t> of_wire_;
  std::deque<OwnedChange> waiting_;
  std::map<std::string, std::uint64_t> place_;  ///< of the change of a key, counted from the first one ever
  std::uint64_t first_ = 0;                     ///< place of the front
  std::size_t bytes_ = 0;
  bool lost_ = false;                         ///< changes were dropped
  std::set<std::string, std::less<>> fresh_;  ///< keys that came since the observed snapshot began
};

}  // namespace rubicon::tuples::carry
