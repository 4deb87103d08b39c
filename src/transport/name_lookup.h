#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "transport/udp.h"

namespace rubicon::transport {

/// Looks up host names on threads of its own, so that neither the loop nor the end of the process waits for a name
/// server. Must be destroyed before the io_context of its executor; this drops the pending lookups.
class NameLookup {
 public:
  /// The calls run on this executor.
  explicit NameLookup(const boost::asio::any_io_executor& executor);
  ~NameLookup();
  NameLookup(const NameLookup&) = delete;
  NameLookup& operator=(const NameLookup&) = delete;

  /// As Transports::look_up; kBusy if too many lookups are pending.
  std::unique_ptr<Lookup> look_up(const std::string& host, LookupDone done);

 private:
  struct Replies;
  std::shared_ptr<Replies> replies_;
};

}  // namespace rubicon::transport
