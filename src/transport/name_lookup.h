#pragma once

#include <memory>

#include "transport/udp.h"

namespace boost::asio {
class io_context;
}

namespace rubicon::transport {

/// Looks names up on threads of their own, so that neither the loop nor the end of the process waits for a name server.
/// A numeric address needs none. Destroyed before its io_context; lookups under way are then forgotten.
class NameLookup {
 public:
  explicit NameLookup(boost::asio::io_context& context);
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

  /// As Transports::look_up; kBusy if too many names that nobody answers are being looked up.
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

 private:
  struct Door;
  std::shared_ptr<Door> door_;
};

}  // namespace rubicon::transport
