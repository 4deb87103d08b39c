#pragma once

#include <map>
#include <tuple>

#include "rubicon/client.hpp"

namespace rubicon::client {

/// What a `<prefix>.<network>.<device>.description` says; kInvalid if the key or the JSON is none.
Result<Device> device_from(OwnerId island, std::string_view key, std::string_view description);
/// `unknown`, `reachable`, `unreachable`, from a `.status`; empty if it says none.
std::string status_from(std::string_view text);
bool fits(const DeviceQuery& query, const Device& device);

/// Follows the devices of all islands by their descriptions and statuses, without creating demand.
class DeviceWatch {
 public:
  DeviceWatch(TupleSpace& space, DeviceQuery query, DeviceCall call);

 private:
  using Name = std::tuple<OwnerId, std::string>;  ///< island, key of the device
  struct Entry {
    std::optional<Device> device;
    std::string status;
    bool told = false;
  };
  void described(const tuples::Event& event);
  void stated(const tuples::Event& event);
  void tell(Entry& entry);
  void forget(const Name& name);

  DeviceQuery query_;
  DeviceCall call_;
  std::map<Name, Entry> entries_;
  tuples::Handle descriptions_, statuses_;
};

}  // namespace rubicon::client
