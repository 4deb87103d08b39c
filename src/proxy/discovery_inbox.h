#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "proxy/proxy.h"
#include "proxy/proxy_context.h"
#include "state/state_store.h"

namespace rubicon::proxy {

/// A device as its network spells it.
struct DeviceName {
  std::string network, address;
  friend auto operator<=>(const DeviceName&, const DeviceName&) = default;
};

/// What a device last said of itself.
struct Announced {
  model::Join join;
  SteadyTime heard_at{};  ///< meaningless if the join says that it was not heard
  WallTime joined{};      ///< where devices roam: the join's time, later than any other island's; zero = not heard
};

/// Why a device is in the inbox and not in the directory.
enum class Standing : std::uint8_t {
  kWaits,  ///< for somebody's word
  kLetIn,  ///< it may come, but its key is taken or there is no room: tried again when it speaks, or at a reload
  kIgnoredByRule,  ///< not seen; makes room for others
  kIgnoredByUser,
};

/// The devices that announced themselves and are not in the directory. Shows those that wait, for a word or for room,
/// as tuples (docs/inbox.md): `proxy.inbox` in all, `proxy.inbox.<network>.<device>` each.
class DiscoveryInbox {
 public:
  explicit DiscoveryInbox(ProxyContext& context);

  /// Makes `proxy.inbox`.
  void begin();

  struct Entry {
    Announced announced;
    Standing standing = Standing::kIgnoredByRule;
    std::string why;  ///< it stands so
    WallTime since{};
    std::string key;  ///< of its tuple; empty = not seen

    bool ignored() const { return standing == Standing::kIgnoredByRule || standing == Standing::kIgnoredByUser; }
  };
  /// What the rules say of a device that is neither known nor named in the configuration, and why.
  std::pair<Admission, std::string> admission(const DeviceName& device, const model::Join& join) const;

  enum class Put : std::uint8_t { kNoRoom, kSame, kNews };
  /// It stands so from now on, or announced itself again.
  Put put(const DeviceName& device, const Announced& announced, Standing standing, std::string why);
  /// True if the device is here: it said something, which goes no further.
  bool heard(const DeviceName& device);
  const Entry* find(const DeviceName& device) const;
  /// Out of the inbox, to be joined or dropped.
  std::optional<Entry> take(const DeviceName& device);
  void drop_network(const std::string& network);

  std::vector<DeviceName> all() const;
  /// Those that wait and fit `<network>.<device>`, `*` and `?` as in a glob; they go by the key of their tuple. Or the
  /// one of exactly this network and address, ignored or not.
  std::vector<DeviceName> waiting_like(const std::string& pattern) const;
  /// Who has this key as its tuple's. If nobody has: the ignored ones that would have it, by address or configuration.
  std::vector<DeviceName> meant_by(const std::string& key) const;

  using Counters = Proxy::InboxCounters;
  const Counters& counters() const { return counters_; }

 private:
  Entry* enter(const DeviceName& device, Standing standing);
  bool make_room(Standing standing);
  void count(const Entry& entry, bool comes);
  void show(const DeviceName& device, Entry& entry);
  void hide(Entry& entry);
  void changed();
  void publish();

  ProxyContext& context_;
  std::map<DeviceName, Entry> entries_;
  std::set<DeviceName> by_rule_;            ///< those ignored by rule
  std::map<std::string, DeviceName> keys_;  ///< of tuples
  Counters counters_;
  Timer timer_;
  SteadyTime publish_at_{};
};

/// But for the wanted key part and whether it was heard.
bool says_the_same(const model::Join& one, const model::Join& other);

/// What the device would announce now.
Announced last_said(const Device& device);

/// The parts of a device's key: `wsn-1.7`.
std::string key_of(const DeviceName& device);

}  // namespace rubicon::proxy
