#pragma once

#include <map>
#include <tuple>

#include "rubicon/client.hpp"

namespace rubicon::client {

/// What a `<prefix>.<network>.<device>.description` says; kInvalid if the key or the JSON is none.
Result<Device> device_from(OwnerId island, std::string_view key, std::string_view description);
bool fits(const DeviceQuery& query, const Device& device);

/// Follows the devices of all islands by their descriptions and statuses, and the lines of their networks, without
/// creating demand.
class DeviceWatch {
 public:
  DeviceWatch(TupleSpace& space, DeviceQuery query, DeviceCall call);

 private:
  using Name = std::tuple<OwnerId, std::string>;  ///< island, key of the device
  struct Entry {
    std::optional<Device> device;
    DeviceCondition condition;
    bool reported = false;
  };
  using Entries = std::map<Name, Entry>;
  void described(const tuples::Event& event);
  void stated(const tuples::Event& event);
  void line_stated(const tuples::Event& event);
  void report(Entry& entry);
  void forget(const Name& name);

  DeviceQuery query_;
  DeviceCall call_;
  Entries entries_;
  std::map<Name, LineStatus> lines_;  ///< by island and key of the network
  tuples::Handle lines_watch_, descriptions_, statuses_;
};

}  // namespace rubicon::client
