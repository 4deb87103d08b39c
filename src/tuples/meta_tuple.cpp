#include "tuples/meta_tuple.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace rubicon::tuples {

/// Follows one reference: returns the name that the last tuple of `chain` holds, or nullopt if that tuple is the
/// target. Errors as for resolve(). The chain begins with the first meta tuple.
Result<std::optional<TupleName>> next_reference(const TupleSpace& space, std::span<const TupleName> chain);

/// Implements subscribe_through(). It evaluates the present tuples instead of single events, so that a thousand changes
/// in a turn cost one move, and a cycle costs nothing until one of its tuples changes. Owned by the Handle, and by a
/// call of the space while it runs.
class Follower : public std::enable_shared_from_this<Follower> {
 public:
  Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call);

  void begin(const TupleName& meta);
  /// No call follows.
  void end();

 private:
  enum class Role { kNone, kReference, kTarget };
  /// The subscription to one tuple of the chain.
  struct Hop {
    Role role = Role::kNone;
    Handle subscription;
  };

  void watch(std::size_t position, Role role);
  using Hops = std::vector<Hop>;
  Hops cut(std::size_t count);
  void on_event(std::size_t position, const Event& event);
  void follow(std::size_t at);
  void forward(const Event& event);
  void report_removed(EventKind how);
  void report_target(Result<TupleName> target);

  TupleSpace& space_;
  Flow flow_;
  EventCall call_;
  TargetCall target_call_;
  std::vector<TupleName> chain_;
  Hops hops_;                                // one for each name of the chain
  std::optional<TupleName> delivered_;       // whose value was delivered, and not reported as removed
  std::optional<Result<TupleName>> target_;  // as reported
  bool ended_ = false;
};

namespace {

constexpr std::string_view kPeisBegin = "(META ";

std::string text_of(std::span<const TupleName> chain) {
  std::string text;
  for (const auto& name : chain) text += (text.empty() ? "" : " -> ") + to_string(name);
  return text;
}

/// `6541:a.b`, with the owner and without wildcards.
Result<TupleName> read_name(std::string_view text) {
  auto pattern = Pattern::parse(text);
  if (!pattern || !pattern->owner || !pattern->exact()) {
    return fail(ErrorCode::kInvalid,
                fmt::format("the reference is {}, expected OWNER:KEY such as 6541:proxy.wsn-1.7.sensor.light-1.value{}",
                            model::quoted(text), pattern ? "" : "; " + pattern.error().text));
  }
  return TupleName{*pattern->owner, std::move(pattern->key)};
}

Result<TupleName> read_peis(std::string_view text) {
  if (text.ends_with('\0')) text.remove_suffix(1);
  const auto blank = text.find(' ', std::min(kPeisBegin.size(), text.size()));
  if (!text.starts_with(kPeisBegin) || !text.ends_with(')') || blank == text.npos) {
    return fail(ErrorCode::kInvalid,
                fmt::format("the reference is {}, expected (META OWNER KEY)", model::quoted(text)));
  }
  const auto owner = text.substr(kPeisBegin.size(), blank - kPeisBegin.size());
  const auto key = text.substr(blank + 1, text.size() - blank - 2);
  if (owner == "-1" && key == "NULL") return fail(ErrorCode::kNotFound, "the reference names nothing");
  return read_name(fmt::format("{}:{}", owner, key));
}

/// Whether `meta` may name `target`. Errors that lie further along the chain do not count.
Result<void> check_target(const TupleSpace& space, const TupleName& meta, const TupleName& target) {
  if (auto ok = model::check_key(meta.key); !ok) return ok;
  if (auto ok = read_name(to_string(target)); !ok) return fail(std::move(ok.error()));
  std::vector<TupleName> chain{meta, target};
  if (target == meta) {
    return fail(ErrorCode::kRefused, fmt::format("meta tuple {}: cycle {}", to_string(meta), text_of(chain)));
  }
  while (true) {
    auto next = next_reference(space, chain);
    const bool ours =
        !next && (next.error().code == ErrorCode::kRefused || next.error().code == ErrorCode::kOutOfRange);
    if (ours) return fail(std::move(next.error()));
    if (!next || !*next) return {};
    chain.push_back(std::move(**next));
  }
}

}  // namespace

std::string to_string(const TupleName& name) {
  return fmt::format("{}:{}", number(name.owner), name.key);
}

bool is_reference(std::string_view media_type) {
  return media_type == kReferenceMediaType || media_type == kPeisReferenceMediaType;
}

Result<TupleName> read_reference(std::string_view media_type, std::string_view value) {
  if (media_type == kPeisReferenceMediaType) return read_peis(value);
  if (media_type != kReferenceMediaType) {
    return fail(ErrorCode::kInvalid, fmt::format("not a meta tuple: its media type is {}, expected {}",
                                                 model::quoted(media_type), kReferenceMediaType));
  }
  if (value.empty()) return fail(ErrorCode::kNotFound, "the reference names nothing");
  return read_name(value);
}

Result<std::optional<TupleName>> next_reference(const TupleSpace& space, std::span<const TupleName> chain) {
  const auto& last = chain.back();
  const auto what = [&] { return "meta tuple " + to_string(chain.front()); };
  const auto tuple = space.get(last.owner, last.key);
  if (!tuple && chain.size() == 1) {
    return fail(ErrorCode::kNotFound, what() + ": does not exist, or is not subscribed to");
  }
  if (!tuple || (!is_reference(tuple->media_type) && chain.size() > 1)) return std::nullopt;
  auto next = read_reference(tuple->media_type, tuple->value);
  if (!next) {
    const auto where = chain.size() == 1 ? std::string() : " at " + to_string(last);
    return fail(next.error().code, what() + where + ": " + next.error().text);
  }
  const auto seen = std::find(chain.begin(), chain.end(), *next);
  if (seen != chain.end()) {
    const std::span<const TupleName> circle(seen, chain.end());
    return fail(ErrorCode::kRefused,
                fmt::format("{}: cycle {} -> {}", what(), text_of(circle), to_string(circle.front())));
  }
  if (chain.size() > kMaxReferences) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: more than {} references in a row: {}", what(), kMaxReferences, text_of(chain)));
  }
  return std::optional(std::move(*next));
}

Result<TupleName> resolve(const TupleSpace& space, const TupleName& meta) {
  std::vector<TupleName> chain{meta};
  while (true) {
    auto next = next_reference(space, chain);
    if (!next) return fail(std::move(next.error()));
    if (!*next) return std::move(chain.back());
    chain.push_back(std::move(**next));
  }
}

Result<void> set_reference(TupleSpace& space, std::string_view key, const TupleName& target) {
  if (auto ok = check_target(space, {space.self(), std::string(key)}, target); !ok) return ok;
  return space.set(key, to_string(target), {.media_type = kReferenceMediaType}).map([](TupleRef) {});
}

Result<std::uint64_t> set_reference(TupleSpace& space, const TupleName& meta, const TupleName& target,
                                    Duration time_to_live, ReplyCall call) {
  if (auto ok = check_target(space, meta, target); !ok) return fail(std::move(ok.error()));
  return space.set_remote(meta.owner, meta.key, to_string(target), time_to_live, std::move(call),
                          {.media_type = kReferenceMediaType});
}

Result<TupleView> get_through(const TupleSpace& space, const TupleName& meta) {
  const auto target = resolve(space, meta);
  if (!target) return fail(target.error());
  if (const auto tuple = space.get(target->owner, target->key)) return *tuple;
  return fail(ErrorCode::kNotFound, fmt::format("meta tuple {}: its target {} does not exist or is not subscribed to",
                                                to_string(meta), to_string(*target)));
}

Result<std::uint64_t> set_through(TupleSpace& space, const TupleName& meta, std::string_view value,
                                  Duration time_to_live, ReplyCall call, const SetOptions& options) {
  const auto target = get_through(space, meta);
  if (!target) return fail(target.error());
  return space.set_remote(target->owner, target->key, value, time_to_live, std::move(call), options);
}

Result<std::uint64_t> append_through(TupleSpace& space, const TupleName& meta, std::string_view bytes,
                                     Duration time_to_live, ReplyCall call, const SetOptions& options) {
  const auto target = get_through(space, meta);
  if (!target) return fail(target.error());
  return space.append_remote(target->owner, target->key, bytes, time_to_live, std::move(call), options);
}

Handle subscribe_through(TupleSpace& space, const TupleName& meta, const Flow& flow, EventCall call,
                         TargetCall target_call) {
  if (!model::check_key(meta.key)) return {};
  auto follower = std::make_shared<Follower>(space, flow, std::move(call), std::move(target_call));
  follower->begin(meta);
  return Handle([follower] { follower->end(); });
}

Follower::Follower(TupleSpace& space, const Flow& flow, EventCall call, TargetCall target_call)
    : space_(space), flow_(flow), call_(std::move(call)), target_call_(std::move(target_call)) {}

void Follower::begin(const TupleName& meta) {
  chain_.push_back(meta);
  hops_.emplace_back();
  watch(0, Role::kReference);
}

void Follower::end() {
  ended_ = true;
  cut(0);
}

/// The new subscription begins before the old one of the same tuple ends, so that the copy stays.
void Follower::watch(std::size_t position, Role role) {
  auto& hop = hops_[position];
  if (hop.role == role) return;
  hop.role = role;
  const Flow passive{.passive = true};
  hop.subscription =
      space_.subscribe({chain_[position].owner, chain_[position].key}, role == Role::kTarget ? flow_ : passive,
                       [follower = weak_from_this(), position](const Event& event) {
                         if (const auto alive = follower.lock()) alive->on_event(position, event);
                       });
}

/// Forgets what comes behind `count` stops; their subscriptions end with the answer.
Follower::Hops Follower::cut(std::size_t count) {
  const auto first = hops_.begin() + static_cast<std::ptrdiff_t>(std::min(count, hops_.size()));
  Hops left(std::make_move_iterator(first), std::make_move_iterator(hops_.end()));
  hops_.erase(first, hops_.end());
  chain_.resize(hops_.size());
  return left;
}

void Follower::on_event(std::size_t position, const Event& event) {
  const bool set = event.kind == EventKind::kSet;
  if (hops_[position].role == Role::kTarget && !(set && is_reference(event.tuple.media_type))) return forward(event);
  if (!set) {
    // If the tuple is created again at once, the target's value is delivered again.
    const auto left = cut(position + 1);
    report_removed(event.kind);
  }
  if (!ended_) follow(position);
}

/// Removed hops stay subscribed until everything is reported, so that the last value can be shown.
void Follower::follow(std::size_t at) {
  Hops left;
  auto next = next_reference(space_, std::span(chain_).first(at + 1));
  for (; next && *next; next = next_reference(space_, std::span(chain_).first(at + 1))) {
    watch(at, Role::kReference);
    if (++at < chain_.size() && chain_[at] == **next) continue;
    if (at < chain_.size()) left = cut(at);
    chain_.push_back(std::move(**next));
    hops_.emplace_back();
  }
  if (at + 1 < chain_.size()) left = cut(at + 1);
  watch(at, next ? Role::kTarget : Role::kReference);
  if (next) return report_target(chain_.back());
  report_removed(EventKind::kDeleted);
  if (!ended_) report_target(fail(std::move(next.error())));
}

void Follower::forward(const Event& event) {
  if (event.kind == EventKind::kSet) {
    delivered_ = chain_.back();
  } else if (!std::exchange(delivered_, std::nullopt)) {
    return;
  }
  call_(event);
}

/// The event shows the last value if it is still known; it is copied, because the call may change the space.
void Follower::report_removed(EventKind how) {
  const auto name = std::exchange(delivered_, std::nullopt);
  if (!name) return;
  Event event{how, {}};
  if (const auto last = space_.get(name->owner, name->key)) event.tuple = *last;
  const std::string value(event.tuple.value);
  const std::string media_type(event.tuple.media_type);
  event.tuple.owner = name->owner;
  event.tuple.key = name->key;
  event.tuple.value = value;
  event.tuple.media_type = media_type;
  call_(event);
}

void Follower::report_target(Result<TupleName> target) {
  const auto same = [&](const Result<TupleName>& reported) {
    return reported ? target && *reported == *target : !target && reported.error() == target.error();
  };
  if (target_ && same(*target_)) return;
  target_ = target;
  if (target_call_) target_call_(target);
}

}  // namespace rubicon::tuples
