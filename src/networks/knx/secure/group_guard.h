#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "networks/knx/secure/group_keys.h"
#include "networks/knx/secure/secured_apdu.h"
#include "networks/knx/secure/sequences.h"

namespace rubicon::networks::knx::secure {

/// Data Secure of the group telegrams of one line (KNX AN158; knx.md, section 11): encrypts what is sent to secured
/// groups, checks and decrypts what comes from them. A secured group takes no plain telegram and gets none. All other
/// groups pass unchanged. Tool access, synchronisation and point to point are not handled.
class GroupGuard {
 public:
  /// Why a frame is not a telegram for us.
  enum class Drop : std::uint8_t {
    kNoTelegram,     ///< not secured, and no group telegram: nothing to do with security, not counted here
    kPlain,          ///< plain, although the group is secured
    kNoKey,          ///< secured, and no key for the group
    kUnknownSender,  ///< not a sender of this group
    kWrongMac,
    kOldSequence,   ///< not above the last of this sender: repeated or replayed
    kToolAccess,    ///< the key of a device instead of the group's
    kSync,          ///< request or response of synchronisation
    kPointToPoint,  ///< to a device or broadcast
    kOther          ///< too short, another algorithm, no group value inside
  };
  static constexpr std::size_t kDrops = 10;

  struct Dropped {
    Drop drop = Drop::kNoTelegram;
    std::string why;  ///< for the user; empty for kNoTelegram
    /// Name of the counter; empty for kNoTelegram.
    std::string_view counter() const;
  };
  using Opened = tl::expected<wire::Telegram, Dropped>;

  /// A decoded frame of a monitor.
  struct Peeked {
    wire::Telegram telegram;
    bool secured = false;
    std::uint64_t sequence = 0;  ///< if secured
  };

  /// `own`: the address that telegrams are sent from, as far as it is known before the line is up, for its known
  /// sequence number; 0.0.0 = not known yet. The
  /// scheduler must outlive it, and what the storage calls. `note` may be empty.
  GroupGuard(Scheduler& scheduler, GroupKeys keys, GroupStorage storage, wire::IndividualAddress own, Note note);
  GroupGuard(const GroupGuard&) = delete;
  GroupGuard& operator=(const GroupGuard&) = delete;

  bool secures(wire::GroupAddress group) const { return keys_.groups.contains(group); }
  /// An error with the reason if telegrams to secured groups cannot be sent: no storage.
  Result<void> can_send() { return own_sequence_.usable(); }

  /// The cEMI frame of a telegram: encrypted if its group is secured, with `own` as the source and the next sequence
  /// number. kRefused: no key, no storage, not a sender of this group, no own address; else the errors of
  /// write_telegram. If the frame is not sent, only a sequence number is lost.
  Result<Bytes> protect(wire::CemiCode code, const wire::Telegram& telegram, wire::IndividualAddress own);
  /// The telegram in a received frame. A secured one counts as received: an equal frame is dropped from then on. `own`:
  /// our present address; what has it as its source is not of a device.
  Opened open(const wire::DataFrame& frame, wire::IndividualAddress own = {});
  /// Decodes a frame of either direction without any effect; senders and sequence numbers are not checked. kRefused:
  /// wrong MAC or no key; kUnsupported: no group telegram.
  Result<Peeked> peek(const wire::DataFrame& frame) const;

  /// By name (`data-secure-...`).
  std::map<std::string, std::uint64_t> counters() const;

 private:
  Opened check(const wire::DataFrame& frame, wire::IndividualAddress own);
  Opened check_secured(const wire::DataFrame& frame, wire::IndividualAddress own);
  Opened accept(const wire::DataFrame& frame, const SecuredApdu& secured, const Key& key);
  Result<const Key*> key_to_send(wire::GroupAddress group, wire::IndividualAddress own) const;
  Result<Bytes> encrypt(wire::CemiCode code, const wire::Telegram& telegram, wire::IndividualAddress own);
  Result<Bytes> secure(const Bytes& plain, const Key& key);

  GroupKeys keys_;
  OwnSequence own_sequence_;
  SenderSequences senders_;
  mutable Ccm ccm_;
  std::array<std::uint64_t, kDrops> dropped_{};
  std::uint64_t sent_ = 0, refused_ = 0, received_ = 0;
};

}  // namespace rubicon::networks::knx::secure
