#pragma once

#include <functional>
#include <string_view>

#include "rubicon/address.hpp"
#include "tuples/judge.h"
#include "web/caller.h"

namespace rubicon::web::api {

struct SetRequest;

/// The one place that decides what a caller may do: by its role, and where the ecology has rights (docs/rights.md), by
/// those of a member that has the name of its token, and as roles that of the token and those beside it. The web server
/// has no rights of its own. Without rights the role alone decides. What is refused is in the audit; what is accepted
/// too, but for reading.
class Permission {
 public:
  /// `judge`: nullptr = there are no rights. `island`: whose rights they are.
  Permission(tuples::Judge* judge, OwnerId island) : judge_(judge), island_(island) {}

  /// Whether its role permits that at all; what it asks for in the end is checked by the other functions.
  Result<void> check_role(const Caller& caller, Verb verb, OwnerId owner, std::string_view key) const;
  /// Whether the caller may read or wake tuples. A pattern is not refused: it gives what access() permits.
  Result<void> check_read(const Caller& caller, Verb verb, OwnerId owner, std::string_view key) const;
  /// Whether it may receive messages for this component: for that it needs to read the tuple GATEWAY.
  Result<void> check_listen(const Caller& caller, OwnerId self, std::string_view type) const;
  /// `can`: whether the server can do it at all now; what it says is in the audit as a refusal.
  Result<void> check_set(const Caller& caller, const SetRequest& request, const Result<void>& can = {}) const;
  Result<void> check_send(const Caller& caller, const Address& to, std::string_view type,
                          const Result<void>& can = {}) const;
  /// To be called with what became of a message that check_send() permitted, an empty text if it was delivered; empty
  /// without rights.
  std::function<void(const std::string& why_not)> send_recorder(const Caller& caller, const Address& to,
                                                                std::string_view type) const;
  /// Before the decisions about devices of an inbox, each of which needs check_set().
  Result<void> check_decisions(const Caller& caller, std::string_view inbox, const Result<void>& can) const;

  /// Whether access() gives it all tuples with all demand.
  bool sees_all(const Caller& caller) const;
  tuples::Access access(const Caller& caller, std::string_view key) const;

  /// Tells the island of this process whose wish a set is that check_set() permitted, as long as the handle lives.
  tuples::Handle speak_for(const Caller& caller, OwnerId self, std::uint64_t request) const;
  /// To be called with the owner's reply to a request that check_set() permitted; empty without rights.
  std::function<void(const tuples::Reply&)> recorder(const SetRequest& request) const;

 private:
  std::string place_of(const Address& to) const;
  void record(const Caller& caller, std::string_view verb, std::string_view key, const Result<void>& answer) const;

  tuples::Judge* judge_;
  OwnerId island_;
};

}  // namespace rubicon::web::api
