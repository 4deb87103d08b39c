#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple.hpp"
#include "rubicon/tuple_space.hpp"
#include "verbs/requests.h"
#include "web/api/context.h"

namespace rubicon::web::api {

/// Writes what a Feed has to send as one frame after another.
class FeedWriter {
 public:
  virtual ~FeedWriter() = default;

  /// The form of a set; the tuple is only valid during the call.
  virtual std::string update(const TupleView& tuple) const = 0;

  // -- the parts of a frame, in this order
  virtual void presence(const std::vector<OwnerId>& owners, bool absent) = 0;
  /// `update` is what update() returned; `introduce` = the client does not know the number of the key yet.
  virtual void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce,
                   std::string_view update) = 0;
  virtual void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) = 0;
  /// The snapshot of this owner is complete. This is the last part of a frame.
  virtual void snapshot(OwnerId owner) = 0;
  /// Bytes of the frame so far.
  virtual std::size_t size() const = 0;
  /// The frame; the next one begins. Empty if it had no parts.
  virtual std::string finish() = 0;

  /// A frame of its own: so many events were dropped.
  virtual std::string lost(std::uint64_t events) = 0;
};

/// Frames of a WebSocket (docs/api.md): JSON, with numbers for keys.
class SocketWriter final : public FeedWriter {
 public:
  SocketWriter(unsigned subscription, bool full) : subscription_(subscription), full_(full) {}

  std::string update(const TupleView& tuple) const override;
  void presence(const std::vector<OwnerId>& owners, bool absent) override;
  void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce, std::string_view update) override;
  void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) override;
  void snapshot(OwnerId owner) override;
  std::size_t size() const override { return head_.size() + keys_.size() + sets_.size() + gone_.size(); }
  std::string finish() override;
  std::string lost(std::uint64_t events) override;

 private:
  unsigned subscription_;
  bool full_;
  std::string head_, keys_, sets_, gone_, tail_;
};

/// Server-sent events (HTML standard, section 9.2): one for each tuple, with the names of the command line.
class StreamWriter final : public FeedWriter {
 public:
  std::string update(const TupleView& tuple) const override;
  void presence(const std::vector<OwnerId>& owners, bool absent) override;
  void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce, std::string_view update) override;
  void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) override;
  void snapshot(OwnerId owner) override;
  std::size_t size() const override { return text_.size(); }
  std::string finish() override;
  std::string lost(std::uint64_t events) override;

 private:
  void add(std::string_view event, std::string_view data);

  std::uint64_t events_ = 0;  ///< since the start: their ids
  std::string text_;
};

/// What all subscriptions of a connection keep: the events that wait to be sent, and what is known of each tuple.
struct EventStock {
  static constexpr std::size_t kMaxEvents = 1000;
  static constexpr std::size_t kMaxBytes = 1024UL * 1024;
  static constexpr std::size_t kMaxTuples = 300'000;  ///< about 200 bytes each
  static constexpr std::size_t kMaxDemands = 1000;    ///< where rights decide about each tuple
  static constexpr std::size_t kMaxHidden = 100'000;  ///< further hidden tuples are judged at each of their sets
  std::size_t events = 0, bytes = 0, tuples = 0, demands = 0;
  std::size_t hidden = 0;  ///< tuples that the caller may not read; they count nowhere, so no caller learns how many
  bool full = false;       ///< there was no room for a tuple or its demand

  bool has_room(std::size_t more) const { return events < kMaxEvents && bytes + more <= kMaxBytes; }
};

/// Why a connection ends whose stock is full.
inline constexpr const char* kTooManyTuples = "more than 300,000 tuples in the subscriptions of this connection";
inline constexpr const char* kTooManyDemands =
    "more than 1,000 tuples in active subscriptions of this connection, whose rights decide about each tuple: "
    "subscribe "
    "to fewer";
inline constexpr const char* kTooManySharedDemands =
    "more than 8,000 tuples in active subscriptions of all connections, whose rights decide about each tuple: try "
    "again "
    "later";

/// One subscription of a client: which tuples changed since the last frame. Of a state it keeps that it changed and
/// reads the value when the frame is made; of an event it keeps each one, while the stock of the connection has room.
/// The keys have numbers, which belong to the subscription. Of a pattern it has what the caller may read, and wakes
/// what it may wake; that is asked once for each tuple.
class Feed {
 public:
  static constexpr std::size_t kMaxFrame = 64UL * 1024;
  /// Between two frames after the snapshot, where a client gives no minimum.
  static constexpr Duration kUsualMinimum = std::chrono::milliseconds(50);

  struct Callbacks {
    std::function<void()> wake;                 ///< there may be a frame
    std::function<void()> merged;               ///< a change replaced one that was not sent yet
    std::function<void(const char* why)> full;  ///< there is no room for a tuple; once for each stock
  };
  Feed(Context& context, Caller caller, EventStock& stock, verbs::Subscription options,
       std::unique_ptr<FeedWriter> writer, Callbacks calls);
  ~Feed();
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  /// The next frame (docs/api.md), about kMaxFrame bytes at most; nullopt: nothing is due.
  std::optional<std::string> next();

 private:
  struct Name {
    OwnerId owner{};
    std::string key;
  };
  struct NameView {
    OwnerId owner{};
    std::string_view key;
  };
  struct NameHash {
    using is_transparent = void;
    std::size_t operator()(const Name& name) const { return (*this)(NameView{name.owner, name.key}); }
    std::size_t operator()(const NameView& name) const {
      return std::hash<std::string_view>()(name.key) * 31 + number(name.owner);
    }
  };
  struct NameEqual {
    using is_transparent = void;
    template <class A, class B>
    bool operator()(const A& a, const B& b) const {
      return a.owner == b.owner && std::string_view(a.key) == std::string_view(b.key);
    }
  };
  struct Entry {
    std::uint32_t number = 0;
    bool introduced = false;  ///< the client knows the number
    Sets sets = Sets::kUnknown;
    bool waits = false;          ///< its state is among the items
    std::uint32_t items = 0;     ///< how many items name it
    std::uint64_t sequence = 0;  ///< of the newest set that is known
    WallTime written{};
    std::optional<EventKind> gone{};  ///< how it ended, if it did
    SharedDemands::Share demand{};    ///< where rights decide about each tuple
  };
  using Entries = std::unordered_map<Name, Entry, NameHash, NameEqual>;
  using Node = Entries::value_type;
  struct Owner {
    bool absent = false;
    std::size_t tuples = 0;  ///< among the entries
  };
  using Owners = std::map<OwnerId, Owner>;
  using Names = std::unordered_set<Name, NameHash, NameEqual>;
  struct Item {
    Node* tuple = nullptr;  ///< nullptr: the snapshot of `owner` ends here
    OwnerId owner{};
    std::string event{};  ///< the update of an event; empty = read the state
  };

  void snapshot_ended(OwnerId owner);
  void changed(const tuples::Event& event);
  void set(const TupleView& tuple);
  void ended(Node& node, EventKind kind);
  void keep_event(Node& node, const TupleView& tuple);
  bool drop_oldest_event();
  void note_lost();
  void peer_changed(OwnerId owner, tuples::PeerEvent event);
  Node* node_of(const TupleView& tuple);
  tuples::Access access(const TupleView& tuple);
  void want(Node& node, const tuples::Access& access);
  void forget(Entries::iterator entry);
  Owners::iterator owner_at(OwnerId owner);
  void forget_if_gone(Owners::iterator owner);
  void forget_hidden(const TupleView& tuple);
  void report_full(const char* why);
  Flow wanted(Duration fastest) const;
  void push(std::deque<Item>& queue, Item item);
  Item pop(std::deque<Item>& queue);
  void leave_stock(const Item& item);
  bool has_items() const { return !items_.empty() || !events_.empty(); }
  bool due() const;
  void wake();

  void add_presence();
  void add(const Item& item);
  void add_update(Node& node, std::string_view update);
  void add_gone(Node& node);
  void fill();

  Context& context_;
  Caller caller_;
  bool judged_;  ///< rights decide about each tuple
  EventStock& stock_;
  verbs::Subscription options_;
  std::unique_ptr<FeedWriter> writer_;
  Callbacks callbacks_;
  Entries entries_;
  Names hidden_;  ///< the caller may not read them
  std::vector<std::uint32_t> free_numbers_;
  std::vector<std::uint32_t> freed_numbers_;  ///< numbers that become free with the present frame
  bool frame_closed_ = false;                 ///< nothing may be added to the present frame
  std::uint32_t next_number_ = 0;
  std::deque<Item> items_;            ///< states, ends of tuples and of snapshots, the first event of a tuple
  std::deque<Item> events_;           ///< all other events; they count in the stock
  std::size_t snapshots_ = 0;         ///< ends of snapshots among the items
  Owners owners_;                     ///< of what was delivered; one that is absent and has no tuples is forgotten
  std::map<OwnerId, bool> presence_;  ///< what the client does not know yet; true = absent
  std::uint64_t lost_events_ = 0;     ///< not reported yet
  SteadyTime not_before_{};
  base::Deadline pause_;
  tuples::Handle data_, demand_, peers_;
};

}  // namespace rubicon::web::api
