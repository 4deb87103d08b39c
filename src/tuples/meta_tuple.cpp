#include "tuples/meta_tuple.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "tuples/follower.h"

namespace rubicon::tuples {

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

}  // namespace rubicon::tuples
