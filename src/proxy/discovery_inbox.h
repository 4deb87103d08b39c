#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "proxy/proxy.h"
#include "proxy/surroundings.h"
#include "state/state_store.h"

namespace rubicon::proxy {

/// A device as its network spells it.
struct DeviceName {
  std::string network, address;
  friend auto operator<=>(const DeviceName&, const DeviceName&) = default;
};

/// The devices that announced themselves and wait for somebody's word, and those that shall not be seen. Shows the
/// waiting ones as tuples (docs/inbox.md): `proxy.inbox` in all, `proxy.inbox.<network>.<device>` each.
class DiscoveryInbox {
 public:
  explicit DiscoveryInbox(Surroundings& around);

  /// Makes `proxy.inbox`.
  void begin();

  struct Entry {
    model::Join join;
    std::string why;  ///< it waits, or is ignored
    WallTime since{};
    SteadyTime heard_at{};
    WallTime heard{};
    bool ignored = false;
    std::string key;  ///< of a waiting device's tuple
  };
  /// What the rules say of a device that is neither known nor named in the configuration, and why.
  std::pair<Admission, std::string> admission(const DeviceName& device, const model::Join& join) const;

  /// It waits from now on, or announced itself again. False: there is no room for it.
  bool wait(const DeviceName& device, const model::Join& join, std::string why);
  /// It is not shown from now on. False: there is no room for it, and it is not remembered here.
  bool ignore(const DeviceName& device, const model::Join& join, std::string why);
  /// True if the device is here: it said something, which goes no further.
  bool heard(const DeviceName& device);
  const Entry* find(const DeviceName& device) const;
  /// Out of the inbox, to be joined or dropped.
  std::optional<Entry> take(const DeviceName& device);
  void drop_network(const std::string& network);

  /// The devices here that fit `<network>.<device>`, ignored ones too; `*` and `?` as in a glob.
  std::vector<DeviceName> matching(std::string_view pattern) const;
  std::vector<DeviceName> waiting() const;

  using Counters = Proxy::InboxCounters;
  const Counters& counters() const { return counters_; }

 private:
  Entry* enter(const DeviceName& device, const model::Join& join, std::string why);
  void show(const DeviceName& device, Entry& entry);
  void hide(const DeviceName& device, Entry& entry);
  void changed();
  void publish();

  Surroundings& around_;
  std::map<DeviceName, Entry> entries_;
  std::set<std::string> keys_;
  Counters counters_;
  Timer timer_;
  SteadyTime publish_at_{};
};

/// The parts of a device's key: `wsn-1.7`.
std::string key_of(const DeviceName& device);

}  // namespace rubicon::proxy
