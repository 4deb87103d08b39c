#include <fmt/format.h>

#include <algorithm>

#include "tuples/space_impl.h"

namespace rubicon::tuples {

Result<TupleRef> TupleSpace::Impl::write(std::string_view key, std::string_view value, const SetOptions& options,
                                         OwnerId creator) {
  if (value.size() > kMaxValueSize) {
    return fail(ErrorCode::kOutOfRange, fmt::format("setting {}: the value has {} bytes, at most {} are allowed",
                                                    model::quoted(key), value.size(), kMaxValueSize));
  }
  auto index = find(self, key);
  if (auto ok = check_sequence(key, index, options); !ok) return fail(std::move(ok.error()));
  if (index == kNone) {
    if (auto ok = model::check_key(key); !ok) return fail(ok.error());
    index = store.create(self, key);
    demand.note(index, {});
  }
  write(index, value, options, creator);
  return TupleRef{index, store.at(index).generation};
}

void TupleSpace::Impl::write(std::uint32_t index, std::string_view value, const SetOptions& options, OwnerId creator) {
  open_turn();
  auto& tuple = store.at(index);
  tuple.value.assign(value);
  set_media_type(tuple, options.media_type);
  stamp(tuple, options, creator);
  if (options.lifetime > Duration(0)) {
    live_for(tuple, index, options.lifetime);
  } else if (tuple.expire_time != WallTime{}) {
    tuple.expire_time = {};
    expiry.clear(index);
  }
  announce(index, EventKind::kSet);
}

Result<TupleRef> TupleSpace::Impl::append(std::string_view key, std::string_view bytes, const SetOptions& options,
                                          OwnerId creator) {
  const auto index = find(self, key);
  if (auto ok = check_append(key, index, bytes.size(), options); !ok) return fail(std::move(ok.error()));
  open_turn();
  auto& tuple = store.at(index);
  tuple.value.append(bytes);
  stamp(tuple, options, creator);
  if (options.lifetime > Duration(0)) live_for(tuple, index, options.lifetime);
  announce(index, EventKind::kSet);
  return TupleRef{index, tuple.generation};
}

Result<void> TupleSpace::Impl::check_sequence(std::string_view key, std::uint32_t index,
                                              const SetOptions& options) const {
  if (!options.expected_sequence) return {};
  const auto expected = *options.expected_sequence;
  const auto present = index == kNone ? 0 : store.at(index).sequence;
  if (expected == present) return {};
  const auto text_of = [](std::uint64_t sequence) {
    return sequence == 0 ? std::string("no such tuple") : fmt::format("sequence {}", sequence);
  };
  return fail(ErrorCode::kRefused, fmt::format("writing {}: expected {}, found {}", model::quoted(key),
                                               text_of(expected), text_of(present)));
}

Result<void> TupleSpace::Impl::check_append(std::string_view key, std::uint32_t index, std::size_t more,
                                            const SetOptions& options) const {
  if (auto ok = check_sequence(key, index, options); !ok) return ok;
  if (index == kNone) {
    return fail(ErrorCode::kNotFound, fmt::format("appending to {}: no such tuple", model::quoted(key)));
  }
  const auto& tuple = store.at(index);
  const auto media_type = store.media_types().name(tuple.media_type);
  if (!options.media_type.empty() && options.media_type != media_type) {
    return fail(ErrorCode::kInvalid, fmt::format("appending to {}: expected its media type {}, got {}",
                                                 model::quoted(key), media_type, model::quoted(options.media_type)));
  }
  if (more <= kMaxValueSize && tuple.value.size() <= kMaxValueSize - more) return {};
  return fail(ErrorCode::kOutOfRange,
              fmt::format("appending to {}: {} bytes after the present {}, expected at most {} in total",
                          model::quoted(key), more, tuple.value.size(), kMaxValueSize));
}

void TupleSpace::Impl::stamp(Tuple& tuple, const SetOptions& options, OwnerId creator) {
  ++tuple.sequence;
  tuple.creator = creator;
  tuple.write_time = wall;
  tuple.user_time = options.user_time;
  ++sets;
}

void TupleSpace::Impl::live_for(Tuple& tuple, std::uint32_t index, Duration lifetime) {
  lifetime = std::min(lifetime, kMaxDuration);
  tuple.expire_time = wall + std::chrono::ceil<std::chrono::microseconds>(lifetime);
  expiry.set(index, lifetime, now);
}

void TupleSpace::Impl::set_media_type(Tuple& tuple, std::string_view name) {
  if (store.media_types().name(tuple.media_type) == name) return;
  tuple.media_type = store.media_types().intern(name);
}

}  // namespace rubicon::tuples
