#pragma once

#include <string>

#include "proxy/tuple_mirror.h"

namespace rubicon::proxy {

/// Names and areas that users give to devices at run time.
class UserNames {
 public:
  UserNames(ProxyContext& context, DeviceDirectory& directory, Memory& memory, TupleMirror& mirror)
      : context_(context), directory_(directory), memory_(memory), mirror_(mirror) {}

  /// A remote set of `proxy.<network>.<device>.description`: JSON with `name`, `area` or both; other members belong to
  /// the device and are refused.
  tuples::SetDecision decide_set(const tuples::RemoteSet& request);

 private:
  Result<void> give(Device& device, std::string name, std::string area, OwnerId by);

  ProxyContext& context_;
  DeviceDirectory& directory_;
  Memory& memory_;
  TupleMirror& mirror_;
};

}  // namespace rubicon::proxy
