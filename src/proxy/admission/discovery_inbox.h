#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "proxy/device.h"
#include "proxy/device_directory.h"
#include "proxy/proxy.h"
#include "proxy/proxy_config.h"

namespace rubicon::proxy::admission {

/// A device as its network spells it.
struct DeviceName {
  std::string network, address;
  friend auto operator<=>(const DeviceName&, const DeviceName&) = default;
};

/// What a device last announced.
struct Announced {
  model::Join join;
  SteadyTime heard_at{};  ///< meaningless if the join was not heard (Join::heard)
  WallTime joined{};      ///< time of the join, later than those other islands know of (Roaming); zero = not heard
};

/// What a listed device would announce now.
Announced last_announcement(const Device& device);

/// Equal but for the wanted key part and whether it was heard.
bool same_announcement(const model::Join& one, const model::Join& other);

/// The parts of a device's key: `wsn-1.7`.
std::string key_of(const DeviceName& device);

/// Why a device is in the inbox and not in the directory.
enum class InboxState : std::uint8_t {
  kPending,        ///< a user has to decide
  kAdmitted,       ///< its key is taken or there is no room: retried at its next message, or at a reload
  kUnusable,       ///< Join::problem; a user cannot approve it
  kIgnoredByRule,  ///< not published; makes room for others
  kIgnoredByUser,  ///< not published
};

/// Reason of InboxState::kIgnoredByUser.
inline constexpr std::string_view kDecidedByUser = "a user decided so";

/// The devices that announced themselves and are not listed. Publishes those that are not ignored
/// (docs/inbox.md): `proxy.inbox` for all, `proxy.inbox.<network>.<device>` for each; and a list of the ignored ones,
/// `proxy.inbox.ignored`.
class DiscoveryInbox {
 public:
  explicit DiscoveryInbox(ProxyContext& context);

  struct Entry {
    Announced announced;
    InboxState state = InboxState::kIgnoredByRule;
    std::string why;  ///< reason of the state
    WallTime since{};
    std::string key;         ///< network and device part of its tuple's key; empty = not published
    std::string hidden_key;  ///< while it is ignored: what `key` would be with its configured id or that of its Join

    bool ignored() const { return state == InboxState::kIgnoredByRule || state == InboxState::kIgnoredByUser; }
  };

  /// Sets `proxy.inbox` and the list of ignored devices for the first time.
  void begin() {
    publish_soon_.call_now();
    publish_ignored_soon_.call_now();
  }
  enum class Put : std::uint8_t { kNoRoom, kSame, kNew };
  /// Adds the device or replaces its entry. kSame: state, reason and announcement did not change.
  Put put(const DeviceName& device, const Announced& announced, InboxState state, std::string why);
  /// True if the device is in the inbox: its message is counted and discarded.
  bool note_message(const DeviceName& device);
  const Entry* find(const DeviceName& device) const;
  /// Removes the device from the inbox.
  std::optional<Entry> take(const DeviceName& device);
  void drop_network(const std::string& network);

  std::vector<DeviceName> devices() const;
  /// The device published with this key; else the one with exactly this network and address, ignored or not; else the
  /// published ones whose key fits the glob `<network>.<device>`.
  std::vector<DeviceName> matching(const std::string& pattern) const;
  /// The device published with this key; else the ignored ones that would have it, by address or configured id.
  std::vector<DeviceName> with_key(const std::string& key) const;

  using Counters = Proxy::InboxCounters;
  const Counters& counters() const { return counters_; }

 private:
  Entry* find_or_add(const DeviceName& device, InboxState state);
  bool make_room(InboxState state);
  void count(const Entry& entry, bool added);
  void show(const DeviceName& device, Entry& entry);
  void hide(Entry& entry);
  void publish();
  void publish_ignored();
  std::string key_with_id(const DeviceName& device, const Entry& entry) const;
  const DeviceName* with_address(const std::string& text) const;
  void index_hidden(const DeviceName& device, Entry& entry);
  void drop_hidden_keys(const DeviceName& device, Entry& entry);

  ProxyContext& context_;
  std::map<DeviceName, Entry> entries_;
  std::set<DeviceName> by_rule_;            ///< those ignored by rule
  std::map<std::string, DeviceName> keys_;  ///< published keys
  /// Of ignored devices: the keys that they would have by address and by id.
  std::set<std::pair<std::string, DeviceName>> hidden_keys_;
  Counters counters_;
  std::string shown_ignored_;
  base::PacedCall publish_soon_, publish_ignored_soon_;
};

struct RuleResult {
  DiscoveryAction action = DiscoveryAction::kAuto;
  std::string why;  ///< which rule: `discovery.rules[2] says ask`
};
/// The action of the first rule that fits the device, else the default.
RuleResult apply_rules(const DiscoveryRules& rules, const DeviceName& device, const model::Join& join);

}  // namespace rubicon::proxy::admission
