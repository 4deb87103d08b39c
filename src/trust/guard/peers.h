#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "trust/guard/certificate.h"

namespace rubicon::trust::guard {

using Handle = long long;  ///< as Cyclone's plug-ins give them; unique in the process, 0 = none
using GuidPrefix = std::array<std::uint8_t, 12>;
using Clock = std::chrono::steady_clock;
using Digest = std::array<std::uint8_t, 32>;  ///< SHA-256

/// Who is at the other end of each GUID prefix that this process met: the remote identities of all domains, from the
/// first message of a stranger until Cyclone returns its handle. Thread-safe.
class Peers {
 public:
  /// More identities than this are not kept: the oldest that has shaken no hands goes, else the oldest that has not
  /// authenticated itself.
  static constexpr std::size_t kMost = 4096;

  /// A peer whose handshake failed waits so long, then twice as long after each further failure. Cyclone alone begins
  /// again after a second, for good: a crowd of strangers would take the processor that a new member needs. Not longer,
  /// because anyone can send a bad message in the name of a peer that is no member yet.
  static constexpr std::chrono::milliseconds kShortestWait{500}, kLongestWait{4'000};

  struct Known {
    Handle identity = 0;
    GuidPrefix prefix{};
  };

  /// False: there is no room, all others are authenticated.
  bool met(Handle identity, const GuidPrefix& prefix);
  /// A handshake with this identity began, or began again.
  void shakes_hands(Handle handshake, Handle identity);
  /// Its handle will be that of another one.
  void is_over(Handle handshake);
  /// nullopt: the identity is not known, or had to go.
  std::optional<Known> of_handshake(Handle handshake) const;
  void authenticated(Handle identity, Certificate certificate);
  /// `foreign`: the certificate in PEM, if no authority of the realm signed it; else empty.
  void failed(Handle identity, Clock::time_point now, std::string_view foreign = {});
  /// True: its last handshake failed a short while ago, the next one has to wait.
  bool must_wait(Handle identity, Clock::time_point now) const;
  /// The same for a handshake that the peer begins, and only with a foreign certificate that was seen before: anyone
  /// can send a bad message in the name of a peer, and must not keep it from sending a good one.
  bool must_wait(Handle identity, std::string_view certificate, Clock::time_point now) const;
  void gone(Handle identity);

  std::optional<Certificate> who(const GuidPrefix& prefix) const;
  std::optional<Certificate> who(Handle identity) const;
  std::optional<GuidPrefix> prefix_of(Handle identity) const;

  void revoke(std::set<std::string> serials);
  /// Whether a peer that authenticated itself is still known and was revoked since.
  bool meets_revoked() const;
  bool is_revoked(const std::string& serial) const;
  std::size_t size() const;

 private:
  /// A process has few participants of its own, each shakes hands once with a remote one.
  static constexpr std::size_t kMostHandshakes = 16;
  struct Identity {
    GuidPrefix prefix{};
    std::uint64_t order = 0;
    std::vector<Handle> handshakes;
    std::optional<Certificate> certificate;
    std::chrono::milliseconds wait{0};
    Clock::time_point not_before{};
    Digest foreign{};  ///< of its last certificate that no authority of the realm signed; zeros = none
  };

  bool make_room();
  void erase(Handle identity);

  mutable std::mutex mutex_;
  std::uint64_t next_ = 0;
  std::unordered_map<Handle, Identity> identities_;
  std::map<std::uint64_t, Handle> strangers_;      ///< that have shaken no hands, the oldest first
  std::map<std::uint64_t, Handle> beginners_;      ///< that shake hands, without certificate, the oldest first
  std::unordered_map<Handle, Handle> handshakes_;  ///< handshake -> identity
  std::map<GuidPrefix, Handle> authenticated_;
  std::set<std::string> revoked_;
};

/// Of this process.
Peers& peers();

}  // namespace rubicon::trust::guard
