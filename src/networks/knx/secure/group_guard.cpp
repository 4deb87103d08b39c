#include "networks/knx/secure/group_guard.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

namespace rubicon::networks::knx::secure {

namespace {

using Drop = GroupGuard::Drop;
using Dropped = GroupGuard::Dropped;

constexpr std::uint8_t kStandardFrame = 0x80;
constexpr std::size_t kMaxStandard = 15, kMaxExtended = 254;

constexpr std::array<std::string_view, GroupGuard::kDrops> kCounters{"",
                                                                     "data-secure-plain-dropped",
                                                                     "data-secure-no-key",
                                                                     "data-secure-unknown-sender",
                                                                     "data-secure-wrong-mac",
                                                                     "data-secure-old",
                                                                     "data-secure-tool-access",
                                                                     "data-secure-synchronisation",
                                                                     "data-secure-point-to-point",
                                                                     "data-secure-other"};

tl::unexpected<Dropped> drop(Drop why, std::string text) {
  return tl::unexpected<Dropped>(Dropped{why, std::move(text)});
}

/// `1.1.10 to 1/2/7`.
std::string path_of(const wire::DataFrame& frame) {
  return fmt::format("{} to {}", to_string(frame.source), to_string(wire::GroupAddress(frame.destination)));
}

/// Services that a secured frame may carry besides data to a group.
std::optional<Dropped> not_handled(const wire::DataFrame& frame, const SecuredApdu& secured) {
  if ((secured.control & control::kToolAccess) != 0)
    return Dropped{Drop::kToolAccess, fmt::format("tool access from {}: not handled", path_of(frame))};
  const auto service = secured.control & control::kService;
  if (service == control::kSyncRequest || service == control::kSyncResponse)
    return Dropped{Drop::kSync,
                   fmt::format("synchronisation of sequence numbers from {}: not handled", path_of(frame))};
  if (service != 0 || (secured.control & control::kSystemBroadcast) != 0 || frame.lte())
    return Dropped{Drop::kOther, fmt::format("secured telegram from {} with control field {:02x}: not handled",
                                             path_of(frame), secured.control)};
  return std::nullopt;
}

/// All senders that are named, with their least last number.
std::map<wire::IndividualAddress, std::uint64_t> start_of(const GroupKeys& keys) {
  auto start = keys.sequences;
  for (const auto& [group, entry] : keys.groups)
    for (const auto sender : entry.senders) start.try_emplace(sender, 0);
  return start;
}

std::uint64_t known_of(const GroupKeys& keys, wire::IndividualAddress own) {
  const auto known = keys.sequences.find(own);
  return number(own) == 0 || known == keys.sequences.end() ? 0 : known->second;
}

}  // namespace

std::string_view GroupGuard::Dropped::counter() const {
  return kCounters.at(static_cast<std::size_t>(drop));
}

GroupGuard::GroupGuard(Scheduler& scheduler, GroupKeys keys, GroupStorage storage, wire::IndividualAddress own,
                       Note note)
    : keys_(std::move(keys)),
      own_sequence_(scheduler, storage, known_of(keys_, own)),
      senders_(scheduler, std::move(storage), start_of(keys_), std::move(note)) {}

// Sending.

Result<Bytes> GroupGuard::protect(wire::CemiCode code, const wire::Telegram& telegram, wire::IndividualAddress own) {
  if (!secures(telegram.destination)) return wire::write_telegram(code, telegram);
  auto secured = encrypt(code, telegram, own);
  ++(secured ? sent_ : refused_);
  return secured;
}

Result<Bytes> GroupGuard::encrypt(wire::CemiCode code, const wire::Telegram& telegram, wire::IndividualAddress own) {
  const auto key = key_to_send(telegram.destination, own);
  if (!key) return fail(key.error());
  own_sequence_.raise(known_of(keys_, own));
  auto from_us = telegram;
  from_us.source = own;
  const auto plain = wire::write_telegram(code, from_us);
  if (!plain) return fail(plain.error());
  auto secured = secure(*plain, **key);
  if (!secured)
    return fail(ErrorCode::kRefused, fmt::format("{} is secured, and nothing can be sent to it: {}",
                                                 to_string(telegram.destination), secured.error().text));
  return secured;
}

Result<const Key*> GroupGuard::key_to_send(wire::GroupAddress group, wire::IndividualAddress own) const {
  const auto& entry = keys_.groups.at(group);
  if (!entry.key)
    return fail(ErrorCode::kRefused,
                fmt::format("{} is secured, and its key is not known: give a keyring with it", to_string(group)));
  if (number(own) != 0 && !entry.may_send_from(own))
    return fail(ErrorCode::kRefused,
                fmt::format("{} is secured, and the keyring has no link between it and {}: devices would ignore the "
                            "telegram. Link them in ETS and export the keyring again",
                            to_string(group), to_string(own)));
  if (number(own) == 0)
    return fail(
        ErrorCode::kRefused,
        fmt::format("{} is secured, and the interface gave this line no address to send from", to_string(group)));
  return &*entry.key;
}

Result<Bytes> GroupGuard::secure(const Bytes& plain, const Key& key) {
  auto frame = wire::read_data_frame(plain);
  if (!frame) return fail(frame.error());
  const auto length = frame->tpdu.size() - 1 + kSecurityBytes;
  if (length > kMaxExtended) return fail(ErrorCode::kOutOfRange, "the value is too long for a secured telegram");
  const auto sequence = own_sequence_.next();
  if (!sequence) return fail(sequence.error());
  const auto tpdu = seal(ccm_, key, *frame, control::kEncrypted, *sequence);
  if (!tpdu) return fail(tpdu.error());
  if (length > kMaxStandard) frame->control1 = static_cast<std::uint8_t>(frame->control1 & ~kStandardFrame);
  frame->tpdu = *tpdu;
  return wire::write(*frame);
}

// Receiving.

GroupGuard::Opened GroupGuard::open(const wire::DataFrame& frame, wire::IndividualAddress own) {
  auto opened = check(frame, own);
  if (!opened) ++dropped_.at(static_cast<std::size_t>(opened.error().drop));
  return opened;
}

GroupGuard::Opened GroupGuard::check(const wire::DataFrame& frame, wire::IndividualAddress own) {
  if (is_secured(frame.tpdu)) return check_secured(frame, own);
  auto telegram = wire::to_telegram(frame);
  if (!telegram) return drop(Drop::kNoTelegram, {});
  if (secures(telegram->destination))
    return drop(Drop::kPlain, fmt::format("plain telegram from {}, which is secured: dropped", path_of(frame)));
  return std::move(*telegram);
}

GroupGuard::Opened GroupGuard::check_secured(const wire::DataFrame& frame, wire::IndividualAddress own) {
  if (!frame.to_group() || frame.destination == 0)
    return drop(Drop::kPointToPoint,
                fmt::format("secured telegram from {} to a device: not handled", to_string(frame.source)));
  const auto secured = read_secured(frame.tpdu);
  if (!secured) return drop(Drop::kOther, fmt::format("telegram from {}: {}", path_of(frame), secured.error().text));
  if (auto other = not_handled(frame, *secured)) return tl::unexpected<Dropped>(std::move(*other));
  const auto group = keys_.groups.find(wire::GroupAddress(frame.destination));
  if (group == keys_.groups.end() || !group->second.key)
    return drop(Drop::kNoKey, fmt::format("secured telegram from {}: no key for this group", path_of(frame)));
  if (!group->second.any_sender && !group->second.senders_to(own).contains(frame.source))
    return drop(Drop::kUnknownSender,
                fmt::format("secured telegram from {}: not a sender of this group", path_of(frame)));
  // A recorded telegram that we sent ourselves is no value of a device.
  if (number(own) != 0 && frame.source == own)
    return drop(
        Drop::kOldSequence,
        fmt::format("secured telegram from {}, which is our own address: sent back or replayed", path_of(frame)));
  return accept(frame, *secured, *group->second.key);
}

/// The MAC is checked first: an old number in a valid telegram means a repetition, in an invalid telegram it means
/// nothing.
GroupGuard::Opened GroupGuard::accept(const wire::DataFrame& frame, const SecuredApdu& secured, const Key& key) {
  const auto plain = secure::open(ccm_, key, frame);
  if (!plain && plain.error().code == ErrorCode::kRefused)
    return drop(Drop::kWrongMac, fmt::format("secured telegram from {}: wrong MAC, so it was changed or encrypted with "
                                             "another key",
                                             path_of(frame)));
  if (!plain) return drop(Drop::kOther, fmt::format("telegram from {}: {}", path_of(frame), plain.error().text));
  const auto last = senders_.last(frame.source);
  if (!last)
    return drop(Drop::kOldSequence, fmt::format("secured telegram from {}: {}", path_of(frame), last.error().text));
  if (secured.sequence <= *last)
    return drop(Drop::kOldSequence,
                fmt::format("secured telegram from {} with sequence number {}, but {} was valid before: repeated, "
                            "replayed, or the device lost its number (then program it again in ETS)",
                            path_of(frame), secured.sequence, *last));
  senders_.set(frame.source, secured.sequence);
  auto inner = frame;
  inner.tpdu = *plain;
  auto telegram = wire::to_telegram(inner);
  if (!telegram) return drop(Drop::kOther, fmt::format("secured telegram from {}: no group value", path_of(frame)));
  ++received_;
  return std::move(*telegram);
}

Result<GroupGuard::Peeked> GroupGuard::peek(const wire::DataFrame& frame) const {
  Peeked out;
  auto inner = frame;
  Bytes plain;
  if (is_secured(frame.tpdu)) {
    const auto secured = read_secured(frame.tpdu);
    if (!secured) return fail(secured.error());
    if (!frame.to_group() || not_handled(frame, *secured))
      return fail(ErrorCode::kUnsupported, "a secured service other than group data");
    const auto group = keys_.groups.find(wire::GroupAddress(frame.destination));
    if (group == keys_.groups.end() || !group->second.key) return fail(ErrorCode::kRefused, "no key for this group");
    auto opened = secure::open(ccm_, *group->second.key, frame);
    if (!opened) return fail(opened.error());
    plain = std::move(*opened);
    inner.tpdu = plain;
    out.secured = true;
    out.sequence = secured->sequence;
  }
  auto telegram = wire::to_telegram(inner);
  if (!telegram) return fail(telegram.error());
  out.telegram = std::move(*telegram);
  return out;
}

std::map<std::string, std::uint64_t> GroupGuard::counters() const {
  std::map<std::string, std::uint64_t> all{
      {"data-secure-sent", sent_}, {"data-secure-refused", refused_}, {"data-secure-received", received_}};
  for (std::size_t i = 1; i < kDrops; ++i) all[std::string(kCounters[i])] = dropped_[i];
  return all;
}

}  // namespace rubicon::networks::knx::secure
