#include "state/announcement.h"

#include "model/former_types.h"
#include "model/message_cbor.h"

namespace rubicon::state {

namespace {

constexpr std::size_t kMaxCached = 256;

Bytes bytes_of(model::Body body) {
  Message message;
  message.body = std::move(body);
  return model::to_cbor(message);
}

std::string key_of(ByteView bytes) {
  return std::string(base::as_text(bytes));
}

/// Empties a full container.
template <class Container>
void bound(Container& container) {
  if (container.size() >= kMaxCached) container.clear();
}

}  // namespace

Result<AnnouncementBytes> AnnouncementWriter::write(const model::Join& join, const PointIds& point_ids) {
  model::Join nameless = join;
  nameless.name.clear();
  nameless.id.clear();
  model::Updates ids;
  for (const auto& [point, id] : point_ids) ids.readings.push_back({point, id, {}});
  AnnouncementBytes bytes{bytes_of(std::move(nameless)), bytes_of(std::move(ids))};
  if (auto sound = check(bytes.capabilities); !sound) return fail(sound.error());
  if (auto sound = check(bytes.point_ids); !sound) return fail(sound.error());
  return bytes;
}

Result<void> AnnouncementWriter::check(const Bytes& bytes) {
  auto key = key_of(bytes);
  if (sound_.contains(key)) return {};
  if (const auto back = model::from_cbor(bytes); !back) return fail(back.error());
  bound(sound_);
  sound_.insert(std::move(key));
  return {};
}

const model::Join* AnnouncementReader::join(ByteView bytes) {
  auto key = key_of(bytes);
  if (const auto known = joins_.find(key); known != joins_.end()) return &known->second;
  auto message = model::from_cbor(bytes);
  auto* join = message ? std::get_if<model::Join>(&message->body) : nullptr;
  if (!join) return nullptr;
  bound(joins_);
  return &joins_.emplace(std::move(key), std::move(*join)).first->second;
}

const PointIds* AnnouncementReader::point_ids(ByteView bytes) {
  auto key = key_of(bytes);
  if (const auto known = point_ids_.find(key); known != point_ids_.end()) return &known->second;
  const auto message = model::from_cbor(bytes);
  const auto* updates = message ? std::get_if<model::Updates>(&message->body) : nullptr;
  if (!updates) return nullptr;
  PointIds ids;
  for (const auto& reading : updates->readings) {
    const auto* id = std::get_if<std::string>(&reading.value);
    if (!id) return nullptr;
    ids.emplace_back(reading.point, model::current_id(*id));
  }
  bound(point_ids_);
  return &point_ids_.emplace(std::move(key), std::move(ids)).first->second;
}

}  // namespace rubicon::state
