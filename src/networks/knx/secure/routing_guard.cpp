#include "networks/knx/secure/routing_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "model/findings.h"

namespace rubicon::networks::knx::secure {

namespace {

using wire::ServiceCode;

constexpr std::size_t kOwnNotifies = 8;
constexpr std::string_view kTimerName = "routing-timer";
/// Timer, limit, wall clock in ms since 1970, and a check value: 8 bytes each, big endian.
constexpr std::size_t kTimerSize = 24, kCheckSize = 8;

std::uint64_t milliseconds(Duration span) {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(span).count());
}

std::uint64_t wall_milliseconds(const Scheduler& scheduler) {
  const auto since_1970 = scheduler.wall_now().time_since_epoch();
  return milliseconds(std::max(std::chrono::duration_cast<Duration>(since_1970), Duration::zero()));
}

void put(Bytes& out, std::uint64_t number) {
  for (int shift = 56; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(number >> shift));
}

std::uint64_t number_at(ByteView bytes, std::size_t at) {
  std::uint64_t number = 0;
  for (std::size_t i = at; i < at + 8; ++i) number = number << 8U | bytes[i];
  return number;
}

/// Shows whether a stored timer is damaged, or of another group.
Result<Bytes> check_of(const Key& key, ByteView timer) {
  Secret text(Key::kSize + timer.size());
  std::copy_n(key.view().begin(), Key::kSize, text.span().begin());
  std::copy(timer.begin(), timer.end(), text.span().begin() + Key::kSize);
  const auto digest = sha256(text.view());
  if (!digest) return fail(digest.error());
  return Bytes(digest->begin(), digest->begin() + kCheckSize);
}

/// The stored timer and the time since then, not below what may have been used. A timer at its end would stay there in
/// the whole group for ever, so nothing is taken that is not ours.
Result<std::uint64_t> first_timer(const Scheduler& scheduler, const GroupStorage& storage, const Key& key) {
  if (!storage.stored) return 0;
  const auto stored = storage.stored(kTimerName);
  if (!stored && stored.error().code == ErrorCode::kUnsupported) return 0;
  if (!stored) return fail(stored.error());
  if (!*stored) return 0;
  const ByteView row = **stored;
  const auto fits = row.size() == kTimerSize + kCheckSize;
  const auto check = fits ? check_of(key, row.first(kTimerSize)) : Result<Bytes>(Bytes());
  if (!check) return fail(check.error());
  if (!fits || !equal(*check, row.subspan(kTimerSize)))
    return fail(ErrorCode::kInvalid, "it is damaged, or of another backbone key");
  const auto then = number_at(row, 16), now = wall_milliseconds(scheduler);
  const auto away = now > then ? std::min(now - then, milliseconds(RoutingGuard::kMaxAway)) : 0;
  return std::max(number_at(row, 0) + away, number_at(row, 8));
}

bool finds_servers(ServiceCode service) {
  return service == ServiceCode::kSearchRequest || service == ServiceCode::kSearchResponse ||
         service == ServiceCode::kSearchRequestExtended || service == ServiceCode::kSearchResponseExtended ||
         service == ServiceCode::kDescriptionRequest || service == ServiceCode::kDescriptionResponse;
}

}  // namespace

Result<std::unique_ptr<RoutingGuard>> RoutingGuard::make(Scheduler& scheduler, RoutingKeys keys, GroupStorage storage,
                                                         const Random& random, Callbacks callbacks) {
  std::array<std::uint8_t, 14> bytes{};
  if (auto done = random(bytes); !done) return fail(done.error());
  RoutingClock::Settings clock;
  clock.latency = keys.latency;
  std::copy_n(bytes.begin(), clock.own.size(), clock.own.begin());
  clock.seed = number_at(bytes, clock.own.size());
  const auto first = first_timer(scheduler, storage, keys.backbone);
  clock.start = first.value_or(0);
  if (!first && callbacks.note)
    callbacks.note("secure-timer", fmt::format("the stored timer of secure routing cannot be used, it begins at 0: {}",
                                               first.error().text));
  return std::make_unique<RoutingGuard>(scheduler, std::move(keys), std::move(storage), clock, std::move(callbacks));
}

RoutingGuard::RoutingGuard(Scheduler& scheduler, RoutingKeys keys, GroupStorage storage,
                           const RoutingClock::Settings& clock, Callbacks callbacks)
    : scheduler_(scheduler),
      keys_(std::move(keys)),
      storage_(std::move(storage)),
      callbacks_(std::move(callbacks)),
      own_(clock.own),
      tag_(static_cast<std::uint16_t>(clock.seed)),
      clock_(scheduler, clock,
             {[this](const Serial& serial, std::uint16_t tag) { send_notify(serial, tag); },
              [this] {
                began_ = clock_.now();
                callbacks_.synchronised();
              }}) {}

RoutingGuard::~RoutingGuard() {
  callbacks_.note = nullptr;  // its owner is being destroyed
  if (used_) store(clock_.now());
}

/// Before a timer is sent, it is stored that it may have been. A disk that fails does not stop the line.
void RoutingGuard::reserve() {
  used_ = true;
  const auto now = clock_.now(), limit = now + milliseconds(kReserve);
  if ((now < limit_ && limit_ <= limit) || scheduler_.now() < store_again_) return;
  if (store(limit)) {
    limit_ = limit;
  } else {
    store_again_ = scheduler_.now() + kStoreAgain;
  }
}

bool RoutingGuard::store(std::uint64_t limit) {
  if (!storage_.store) return true;
  Bytes bytes;
  put(bytes, clock_.now());
  put(bytes, limit);
  put(bytes, wall_milliseconds(scheduler_));
  const auto check = check_of(keys_.backbone, bytes);
  if (check) bytes.insert(bytes.end(), check->begin(), check->end());
  const auto stored = check ? storage_.store(kTimerName, bytes) : Result<void>(fail(check.error()));
  if (stored || stored.error().code == ErrorCode::kUnsupported) return true;
  if (callbacks_.note)
    callbacks_.note("secure-timer", fmt::format("the timer of secure routing is not kept: {}", stored.error().text));
  return false;
}

Result<ByteView> RoutingGuard::wrap(ByteView frame) {
  if (!synchronised())
    return fail(ErrorCode::kRefused, "the timer of the secure routing group is not known yet, so nothing can be sent");
  if (clock_.now() >= RoutingClock::kMaxTimer)
    return fail(ErrorCode::kRefused,
                "the timer of the secure routing group is at its end, so nothing can be sent: give the backbone a new "
                "key in ETS");
  reserve();
  const WrapperHead head{0, clock_.now(), own_, ++tag_};
  if (auto done = seal_wrapper(ccm_, keys_.backbone, head, frame, out_); !done) return fail(done.error());
  ++counters_.sent;
  clock_.sent_wrapper();
  return ByteView(out_);
}

void RoutingGuard::send_notify(const Serial& serial, std::uint16_t tag) {
  if (clock_.now() >= RoutingClock::kMaxTimer) return;
  reserve();
  TimerNotify notify{clock_.now(), serial, tag, {}};
  const auto plain = write(notify);
  const auto header = ByteView(plain).first(wire::kHeaderSize);
  const auto nonce = nonce_of({0, notify.timer, serial, tag}, 0);
  if (!ccm_.seal(keys_.backbone, nonce, header, {}, notify.mac)) return;  // OpenSSL fails: wrap() says so
  ++counters_.notifies_sent;
  notifies_.push_back({notify.timer, serial, tag});
  if (notifies_.size() > kOwnNotifies) notifies_.pop_front();
  callbacks_.transmit(write(notify));
}

bool RoutingGuard::is_discovery(ByteView datagram) {
  const auto frame = wire::read_frame(datagram);
  return frame && finds_servers(frame->service);
}

ByteView RoutingGuard::receive(const std::string& from, ByteView datagram) {
  in_.clear();
  const auto frame = wire::read_frame(datagram);
  if (!frame) {
    drop(counters_.bad, "bad-frames", from, fmt::format("sent a frame that cannot be read: {}", frame.error().text));
    return {};
  }
  if (finds_servers(frame->service)) return datagram;
  if (frame->service == ServiceCode::kSecureWrapper) return receive_wrapper(from, *frame);
  if (frame->service == ServiceCode::kTimerNotify) {
    receive_notify(from, *frame);
  } else {
    drop(counters_.plain, "secure-plain-frames", from,
         fmt::format("sent {} without encryption: dropped", to_string(frame->service)));
  }
  return {};
}

/// Everything is checked after the MAC: nothing that is not authentic has an effect.
ByteView RoutingGuard::receive_wrapper(const std::string& from, const wire::Frame& frame) {
  const auto wrapper = read_wrapper(frame);
  if (!wrapper || wrapper->head.session != 0) {
    drop(counters_.bad, "bad-frames", from, "sent a wrapper that is not one of routing");
    return {};
  }
  const auto opened = open_wrapper(ccm_, keys_.backbone, *wrapper, in_);
  if (!opened || *opened == Opened::kWrongMac) {
    drop(counters_.wrong_mac, "secure-wrong-mac", from,
         "sent a telegram with a wrong MAC: it was changed, or has another backbone key");
    return {};
  }
  if (wrapper->head.serial == own_) {
    ++counters_.own;
    return {};
  }
  if (!accept(from, wrapper->head)) return {};
  if (*opened == Opened::kForbidden) {
    drop(counters_.forbidden, "secure-forbidden", from, "wrapped a frame that a wrapper must not hold");
    return {};
  }
  ++counters_.received;
  return in_;
}

/// True if the wrapper is neither old nor repeated.
bool RoutingGuard::accept(const std::string& from, const WrapperHead& head) {
  using Verdict = RoutingClock::Verdict;
  const Seen one{head.sequence, head.serial, head.tag};
  if (clock_.synchronised() && is_repeated(one)) {
    drop(counters_.replays, "secure-replays", from, "sent a telegram once more: dropped");
    return false;
  }
  const auto verdict = clock_.received_wrapper(head.sequence, head.serial, head.tag);
  if (verdict == Verdict::kOld) {
    drop(counters_.old, "secure-old", from,
         fmt::format("sent a telegram that is {} ms old, beyond the latency tolerance: dropped",
                     clock_.now() - head.sequence));
    return false;
  }
  if (verdict == Verdict::kEarly || head.sequence < began_) {
    drop(counters_.early, "secure-early", from, "sent a telegram before the timer of the group was known: dropped");
    return false;
  }
  remember(one);
  return true;
}

void RoutingGuard::remember(const Seen& one) {
  if (seen_.size() == kMaxRemembered) {
    floor_ = std::max(floor_, seen_.front().timer + 1);
    seen_.pop_front();
  }
  seen_.push_back(one);
}

bool RoutingGuard::is_repeated(const Seen& one) {
  const auto now = clock_.now(), latency = milliseconds(clock_.latency());
  while (!seen_.empty() && seen_.front().timer + latency <= now) seen_.pop_front();
  return one.timer < floor_ || std::find(seen_.begin(), seen_.end(), one) != seen_.end();
}

Result<bool> RoutingGuard::has_good_mac(const TimerNotify& notify) {
  const auto plain = write(TimerNotify{notify.timer, notify.serial, notify.tag, {}});
  const auto nonce = nonce_of({0, notify.timer, notify.serial, notify.tag}, 0);
  return ccm_.open(keys_.backbone, nonce, ByteView(plain).first(wire::kHeaderSize), {}, notify.mac);
}

void RoutingGuard::receive_notify(const std::string& from, const wire::Frame& frame) {
  const auto notify = read_timer_notify(frame);
  if (!notify) return drop(counters_.bad, "bad-frames", from, notify.error().text);
  const auto good = has_good_mac(*notify);
  if (!good || !*good)
    return drop(counters_.wrong_mac, "secure-wrong-mac", from, "sent a TIMER_NOTIFY with a wrong MAC");
  const Seen one{notify->timer, notify->serial, notify->tag};
  if (std::find(notifies_.begin(), notifies_.end(), one) != notifies_.end()) return void(++counters_.own);
  ++counters_.notifies_received;
  clock_.received_notify(notify->timer, notify->serial, notify->tag);
}

void RoutingGuard::drop(std::uint64_t& counter, std::string_view subject, const std::string& from,
                        std::string_view what) {
  ++counter;
  if (callbacks_.note) callbacks_.note(subject, fmt::format("{} {}", from, what));
}

std::string RoutingGuard::problem() const {
  if (counters_.received + counters_.notifies_received > 0) return {};
  return counters_.wrong_mac > 0
             ? "what the group sends has another backbone key: compare the keyring with the ETS project"
             : "no other member of the secure routing group was heard yet: is a secure router there, and is it this "
               "multicast group?";
}

std::string_view RoutingGuard::finding() const {
  if (problem().empty()) return {};
  return counters_.wrong_mac > 0 ? model::findings::kBackboneOther : model::findings::kBackboneAlone;
}

std::map<std::string, std::uint64_t> RoutingGuard::counters() const {
  return {{"secure-sent", counters_.sent},
          {"secure-received", counters_.received},
          {"secure-plain-frames", counters_.plain},
          {"secure-wrong-mac", counters_.wrong_mac},
          {"secure-old", counters_.old},
          {"secure-early", counters_.early},
          {"secure-replays", counters_.replays},
          {"secure-forbidden", counters_.forbidden},
          {"secure-bad-frames", counters_.bad},
          {"secure-own-frames", counters_.own},
          {"secure-notifies-sent", counters_.notifies_sent},
          {"secure-notifies-received", counters_.notifies_received}};
}

}  // namespace rubicon::networks::knx::secure
