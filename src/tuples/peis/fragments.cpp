#include "tuples/peis/fragments.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"

namespace rubicon::tuples::peis {

Result<std::uint16_t> count_fragments(std::size_t size) {
  if (size > kMaxMessage)
    return fail(ErrorCode::kOutOfRange, fmt::format("message of {} bytes, expected at most {}", size, kMaxMessage));
  return static_cast<std::uint16_t>(std::max<std::size_t>(1, (size + kMaxBody - 1) / kMaxBody));
}

ByteView fragment_of(ByteView message, std::uint16_t index) {
  const auto at = std::size_t{index} * kMaxBody;
  RUBICON_ASSERT(at <= message.size());
  return message.subspan(at, std::min(kMaxBody, message.size() - at));
}

Fragments::Fragments(Scheduler& scheduler, const Limits& limits)
    : scheduler_(scheduler), limits_(limits), next_(scheduler, [this] { sweep(); }) {}

Result<std::optional<Bytes>> Fragments::add(const PackageHeader& header, ByteView body) {
  if (const auto good = check(header); !good) return fail(good.error());
  if (was_here(header)) {
    ++counters_.duplicates;
    return std::nullopt;
  }
  auto place = place_of(header);
  const bool starts = place == open_.end();
  if (const auto room = check_room(header.source, starts, body.size() + kOverhead); !room) return fail(room.error());
  if (starts) place = start(header);
  store(place, header, body);
  if (place->parts.size() < place->fragments) return std::nullopt;
  return complete(place);
}

Result<void> Fragments::check(const PackageHeader& header) {
  const bool good = header.fragments > 0 && header.fragments <= kMaxFragments && header.fragment < header.fragments;
  if (good) return {};
  ++counters_.invalid;
  return fail(ErrorCode::kInvalid,
              fmt::format("fragment {} of {} from {}, expected an index below a count of 1 to {}", header.fragment,
                          header.fragments, number(header.source), kMaxFragments));
}

Result<void> Fragments::check_room(OwnerId source, bool starts, std::size_t cost) {
  const auto known = shares_.find(source);
  const Share share = known == shares_.end() ? Share{} : known->second;
  const std::size_t more = starts ? 1 : 0;
  const bool fits = total_.messages + more <= limits_.messages && share.messages + more <= limits_.messages_of_source &&
                    total_.bytes + cost <= limits_.bytes && share.bytes + cost <= limits_.bytes_of_source;
  if (fits) return {};
  ++counters_.refused;
  return fail(ErrorCode::kBusy,
              fmt::format("fragment from {}: {} of its messages with {} bytes are incomplete, {} with {} bytes in all",
                          number(source), share.messages, share.bytes, total_.messages, total_.bytes));
}

bool Fragments::was_here(const PackageHeader& header) const {
  const auto known = places_.find(Key{header.source, header.message});
  if (known == places_.end()) return false;
  const auto& message = *known->second;
  if (message.complete()) return std::binary_search(message.ack_ids.begin(), message.ack_ids.end(), header.ack_id);
  const auto part = message.parts.find(header.fragment);
  return part != message.parts.end() && part->second.ack_id == header.ack_id;
}

/// The incomplete message that the fragment belongs to, or the end. Ids come again after 32767 messages or a restart of
/// the source: a message that the fragment contradicts is an older one.
Fragments::Place Fragments::place_of(const PackageHeader& header) {
  const auto known = places_.find(Key{header.source, header.message});
  if (known == places_.end()) return open_.end();
  const auto place = known->second;
  const bool same = !place->complete() && place->fragments == header.fragments && place->port == header.port &&
                    !place->parts.contains(header.fragment);
  if (same) return place;
  if (!place->complete()) ++counters_.replaced;
  remove(place);
  return open_.end();
}

Fragments::Place Fragments::start(const PackageHeader& header) {
  Message message;
  message.key = {header.source, header.message};
  message.port = header.port;
  message.fragments = header.fragments;
  const auto place = open_.insert(open_.end(), std::move(message));
  places_[place->key] = place;
  ++total_.messages;
  ++shares_[header.source].messages;
  return place;
}

void Fragments::store(Place place, const PackageHeader& header, ByteView body) {
  const auto cost = body.size() + kOverhead;
  place->parts.emplace(header.fragment, Part{header.ack_id, Bytes(body.begin(), body.end())});
  place->cost += cost;
  place->last = scheduler_.now();
  total_.bytes += cost;
  shares_[header.source].bytes += cost;
  open_.splice(open_.end(), open_, place);
  next_.advance_to(place->last + limits_.timeout);
}

Bytes Fragments::complete(Place place) {
  Bytes whole;
  whole.reserve(place->cost - place->parts.size() * kOverhead);
  for (const auto& [index, part] : place->parts) {
    whole.insert(whole.end(), part.bytes.begin(), part.bytes.end());
    place->ack_ids.push_back(part.ack_id);
  }
  std::sort(place->ack_ids.begin(), place->ack_ids.end());
  ++counters_.messages;
  release(*place);
  done_.splice(done_.end(), open_, place);
  remembered_ += place->ack_ids.size();
  while (remembered_ > limits_.remembered) remove(done_.begin());
  return whole;
}

/// Gives the room of an incomplete message back.
void Fragments::release(Message& message) {
  const auto share = shares_.find(message.key.source);
  --total_.messages;
  total_.bytes -= message.cost;
  share->second.bytes -= message.cost;
  if (--share->second.messages == 0) shares_.erase(share);
  message.cost = 0;
  message.parts.clear();
}

void Fragments::remove(Place place) {
  places_.erase(place->key);
  if (place->complete()) {
    remembered_ -= place->ack_ids.size();
    done_.erase(place);
  } else {
    release(*place);
    open_.erase(place);
  }
}

void Fragments::forget(OwnerId source) {
  for (auto* messages : {&open_, &done_}) {
    for (auto place = messages->begin(); place != messages->end();) {
      const auto next = std::next(place);
      if (place->key.source == source) remove(place);
      place = next;
    }
  }
}

void Fragments::sweep() {
  const auto now = scheduler_.now();
  for (; !open_.empty() && open_.front().last + limits_.timeout <= now; ++counters_.expired) remove(open_.begin());
  while (!done_.empty() && done_.front().last + limits_.remember <= now) remove(done_.begin());
  if (!open_.empty()) next_.advance_to(open_.front().last + limits_.timeout);
  if (!done_.empty()) next_.advance_to(done_.front().last + limits_.remember);
}

}  // namespace rubicon::tuples::peis
