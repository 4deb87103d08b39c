#pragma once

#include <functional>
#include <string_view>

#include "rubicon/address.hpp"
#include "tuples/judge.h"
#include "web/exchange.h"

namespace rubicon::web::api {

struct SetRequest;

/// The one place that decides what a caller may do: by its role and, if the ecology has rights (docs/rights.md), by the
/// rights of a member with the name of the token. That member has the roles of the token. The web server has no rights
/// of its own. Without rights the role alone decides. What is refused is in the audit; what is accepted too, but for
/// reading.
class Permission {
 public:
  /// `judge`: nullptr = there are no rights. `island`: whose rights they are. `knows_callers`: each needs a token.
  Permission(tuples::Judge* judge, OwnerId island, bool knows_callers)
      : judge_(judge), island_(island), knows_callers_(knows_callers) {}

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
  /// Call before decisions about devices of an inbox; each decision needs check_set() too.
  Result<void> check_decisions(const Caller& caller, std::string_view inbox, const Result<void>& can) const;

  /// Whether access() gives it all tuples with all demand.
  bool sees_all(const Caller& caller) const;
  tuples::Access access(const Caller& caller, std::string_view key) const;

  /// Tells the island of this process who is behind a set that check_set() permitted, as long as the handle lives.
  tuples::Handle speak_for(const Caller& caller, OwnerId self, std::uint64_t request) const;
  /// To be called with the owner's reply to a request that check_set() permitted; empty without rights.
  std::function<void(const tuples::Reply&)> recorder(const SetRequest& request) const;

 private:
  std::string place_of(const Address& to) const;
  Result<void> check_place(const Caller& caller, std::string_view key, std::string_view value) const;
  void record(const Caller& caller, std::string_view verb, std::string_view key, const Result<void>& answer) const;

  tuples::Judge* judge_;
  OwnerId island_;
  bool knows_callers_;
};

}  // namespace rubicon::web::api
