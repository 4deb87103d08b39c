#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "tuples/peis/wire.h"

namespace rubicon::tuples::peis {

/// Longest message: a kernel counts fragments in 15 bits (peis.md, section 1.1).
inline constexpr std::uint16_t kMaxFragments = 0x7fff;
inline constexpr std::size_t kMaxMessage = std::size_t{kMaxFragments} * kMaxBody;
inline constexpr std::uint16_t kMaxMessageId = 0x7fff;  ///< of long messages, from 1

/// Into how many packages a message goes: 1 = a whole one. kOutOfRange: longer than kMaxMessage.
Result<std::uint16_t> count_fragments(std::size_t size);
/// What the package of this index carries.
ByteView fragment_of(ByteView message, std::uint16_t index);

/// Assembles long messages of all sources. Nothing that a peer sends makes it hold more than its limits: what goes
/// beyond is refused, and must not be acknowledged, so that the source sends it again.
class Fragments {
 public:
  struct Limits {
    std::size_t messages = 512;  ///< incomplete ones
    std::size_t messages_of_source = 128;
    std::size_t bytes = 80 << 20;            ///< of incomplete messages, with kOverhead for each fragment
    std::size_t bytes_of_source = 40 << 20;  ///< the longest message fits
    std::size_t remembered = 16384;          ///< fragments of complete messages, by which late duplicates are known
    Duration timeout = kAssemblyTimeout;     ///< without a fragment
    Duration remember = std::chrono::seconds(12);  ///< longer than a source sends again
  };
  struct Counters {
    std::uint64_t messages = 0;    ///< complete
    std::uint64_t duplicates = 0;  ///< fragments that were here
    std::uint64_t refused = 0;     ///< fragments beyond a limit
    std::uint64_t invalid = 0;     ///< fragments whose numbers contradict themselves
    std::uint64_t replaced = 0;    ///< incomplete messages whose id was used again
    std::uint64_t expired = 0;     ///< incomplete messages that nothing came for
  };
  /// Memory that a fragment takes besides its bytes, about.
  static constexpr std::size_t kOverhead = 128;

  explicit Fragments(Scheduler& scheduler) : Fragments(scheduler, Limits{}) {}
  Fragments(Scheduler& scheduler, const Limits& limits);

  /// Takes a package whose header has `fragments` > 0. Returns the whole message when this was its last missing part;
  /// nullopt if others are missing, or this one was here (same index and ack id). kInvalid: the numbers contradict
  /// themselves; kBusy: a limit, do not acknowledge it.
  Result<std::optional<Bytes>> add(const PackageHeader& header, ByteView body);
  /// The source ended or started again: forgets its messages.
  void forget(OwnerId source);

  const Counters& counters() const { return counters_; }
  std::size_t incomplete() const { return open_.size(); }
  std::size_t bytes() const { return total_.bytes; }

 private:
  struct Key {
    OwnerId source{};
    std::uint16_t message = 0;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      return std::hash<std::uint64_t>{}(std::uint64_t{number(key.source)} << 16 | key.message);
    }
  };
  struct Part {
    std::uint32_t ack_id = 0;
    Bytes bytes;
  };
  struct Message {
    Key key;
    Port port{};
    std::uint16_t fragments = 0;
    std::map<std::uint16_t, Part> parts{};  ///< by index; empty once complete
    std::vector<std::uint32_t> ack_ids{};   ///< of a complete one, sorted
    std::size_t cost = 0;
    SteadyTime last{};  ///< when a part came
    bool complete() const { return !ack_ids.empty(); }
  };
  using Place = std::list<Message>::iterator;
  struct Share {
    std::size_t messages = 0, bytes = 0;
  };

  Result<void> check(const PackageHeader& header);
  Result<void> check_room(OwnerId source, bool starts, std::size_t cost);
  bool was_here(const PackageHeader& header) const;
  Place place_of(const PackageHeader& header);
  Place start(const PackageHeader& header);
  void store(Place place, const PackageHeader& header, ByteView body);
  Bytes complete(Place place);
  void release(Message& message);
  void remove(Place place);
  void sweep();

  Scheduler& scheduler_;
  Limits limits_;
  Counters counters_;
  std::list<Message> open_, done_;  ///< in the order of their last part
  std::unordered_map<Key, Place, KeyHash> places_;
  std::unordered_map<OwnerId, Share> shares_;
  Share total_;
  std::size_t remembered_ = 0;
  base::Deadline next_;
};

}  // namespace rubicon::tuples::peis
