#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"

namespace rubicon::web {

/// What a caller may do; each role includes those before it.
enum class Role : std::uint8_t {
  kNone,     ///< not known: nothing but the page itself and its login
  kView,     ///< read and subscribe, passively or with demand
  kCommand,  ///< set tuples, send messages
  kAdmin,    ///< inbox, reload, recorders, messages that change an installation
};

/// Who sent a request, as far as the server knows.
struct Caller {
  std::string name;  ///< of the token; `local` without tokens
  Role role = Role::kNone;
  std::string peer;                  ///< IP address
  std::uint64_t session = 0;         ///< of the login that the request's cookie names; 0 = none
  std::vector<std::string> roles{};  ///< of the token besides its role: names that rules may have
};

enum class Verb : std::uint8_t { kRead, kWake, kSet, kSend };

/// What the role of a caller permits; where the ecology has rights, api::Permission asks them too. `key` is a tuple key
/// (kSet), a pattern (kRead, kWake) or a content type (kSend). Keys that steer the island itself (inbox, settings,
/// recorders, lines) and messages that change an installation (model::is_admin_type()) need kAdmin.
bool may(const Caller& caller, Verb verb, OwnerId owner, std::string_view key);

}  // namespace rubicon::web
