#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "rubicon/result.hpp"
#include "tuples/member.h"

namespace rubicon::tuples::dds {

/// The first 12 bytes of the GUIDs of a participant and of all its endpoints (DDSI-RTPS 2.5, 8.2.4.1).
using GuidPrefix = std::array<std::uint8_t, 12>;

/// What a process needs to take part with DDS Security, and what it knows of the certificates of others. Implemented by
/// `trust`; outlives the ecology.
class DdsTrust {
 public:
  /// Values of the properties of DDS Security 1.1, section 9.3.1 and 9.4.1: `file:PATH` or `data:,TEXT`.
  struct Documents {
    std::string identity_ca, certificate, private_key, permissions_ca, governance, permissions;
    std::string contents{};  ///< of all but the key, to compare; empty = not known, which counts as changed
  };

  virtual ~DdsTrust() = default;

  /// The documents of this process as they are on the disk now, checked; the error names the file, what is wrong, and
  /// what was expected. Called before each start of the domain: also when it is renewed.
  virtual Result<Documents> documents() = 0;
  /// The library with the three plug-ins of the guard.
  virtual std::string guard_library() const = 0;
  /// The member that this process is, by the documents it read last.
  virtual const Member& own() const = 0;

  /// Thread-safe, does not block: the member that authenticated itself with this GUID prefix and is neither revoked nor
  /// expired. nullopt: none.
  virtual std::optional<Member> who(const GuidPrefix& participant) const = 0;
  /// A signed list of revoked certificates arrived from the member `from`: takes it if the signature is good and its
  /// number is higher. True: it is new, and some members of who() may be gone.
  virtual bool take_revoked(std::string_view signed_list, std::string_view from) = 0;
  /// Whether a process that authenticated itself is still here and was revoked since. It reads on until the domain is
  /// made again, even if it never showed itself as a component.
  virtual bool meets_revoked() const { return false; }
  /// Whether this process itself was revoked: it has to leave.
  virtual bool is_revoked() const { return false; }
  /// The newest signed list, to be published; empty = there is none.
  virtual std::string revoked() const = 0;
  /// `call` runs on the loop, in a turn of its own, when a newer list was found on the disk (`rubicon trust dds revoke`
  /// wrote it): publish it, and drop the peers that who() no longer knows. It replaces the former call; empty ends it.
  virtual void watch_revoked(std::function<void()> call) { std::ignore = call; }
  /// What is known of a peer that was refused.
  struct Refusal {
    GuidPrefix peer{};         ///< the prefix of its GUIDs; zeros = not known
    std::string_view name;     ///< of its certificate; empty = none was seen
    bool is_verified = false;  ///< the certificate is that of a member; else it may claim any name
    std::string_view reason;
  };
  using Refused = std::function<void(const Refusal& refusal)>;
  /// `call` runs on a thread of DDS, which holds locks: it may not block. A peer that is refused tries again. It
  /// replaces the former call; empty ends it: afterwards the former one runs no more.
  virtual void watch_refused(Refused call) { std::ignore = call; }
};

}  // namespace rubicon::tuples::dds
