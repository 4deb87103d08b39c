#include "state/rows.h"

#include "model/message.h"
#include "model/type_names.h"

namespace rubicon::state {

namespace {

constexpr std::size_t kMaxCached = 256;
constexpr std::size_t kMaxSoundBytes = 1 << 20;

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
  if (sound_.size() >= kMaxCached || sound_bytes_ + key.size() > kMaxSoundBytes) {
    sound_.clear();
    sound_bytes_ = 0;
  }
  sound_bytes_ += key.size();
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

namespace {

constexpr const char* kSelect =
    "SELECT d.row, d.network, d.address, d.id, d.decision, d.name, d.wanted_id, d.first_seen, d.last_heard, "
    "a.capabilities, a.point_ids, d.given_name, d.area FROM device d LEFT JOIN announcement a ON a.device = d.row ";

/// Reads a row of kSelect.
std::optional<KnownDevice> device_at(const Query& query, AnnouncementReader& announcements) {
  const auto decision = query.integer_at(4);
  const auto* join = announcements.join(query.blob_at(9));
  const auto* point_ids = announcements.point_ids(query.blob_at(10));
  if (!join || !point_ids || decision < 0 || decision > static_cast<int>(Decision::kIgnored)) return std::nullopt;
  KnownDevice device;
  device.network = query.text_at(1);
  device.address = query.text_at(2);
  device.id = query.text_at(3);
  device.decision = static_cast<Decision>(decision);
  device.join = *join;
  device.join.name = query.text_at(5);
  device.join.id = query.text_at(6);
  device.point_ids = *point_ids;
  device.first_seen = query.time_at(7);
  device.last_heard = query.time_at(8);
  device.given_name = query.text_at(11);
  device.area = query.text_at(12);
  return device;
}

}  // namespace

Result<DeviceRows> DeviceRows::prepare(Database& database) {
  struct Entry {
    Statement& statement;
    std::string sql;
    const char* doing;
  };
  DeviceRows rows;
  const Entry entries[] = {
      {rows.row_of_, "SELECT row FROM device WHERE network=? AND address=?", "looking for a device"},
      {rows.exists_, "SELECT 1 FROM device WHERE row=?", "looking for a device"},
      {rows.insert_,
       "INSERT INTO device(id,decision,name,wanted_id,first_seen,last_heard,network,address,given_name,area) "
       "VALUES(?,?,?,?,?,?,?,?,?,?)",
       "writing a device"},
      {rows.insert_announcement_, "INSERT INTO announcement(capabilities,point_ids,device) VALUES(?,?,?)",
       "writing a device"},
      {rows.update_,
       "UPDATE device SET id=?1, decision=CASE ?2 WHEN 0 THEN decision ELSE ?2 END, name=?3, wanted_id=?4, "
       "first_seen=CASE first_seen WHEN 0 THEN ?5 ELSE first_seen END, last_heard=max(last_heard, ?6), "
       "given_name=CASE ?8 WHEN '' THEN given_name ELSE ?8 END, area=CASE ?9 WHEN '' THEN area ELSE ?9 END WHERE "
       "row=?7",
       "writing a device"},
      // Most joins repeat the stored announcement, which is then not written again.
      {rows.update_announcement_,
       "UPDATE announcement SET capabilities=?1, point_ids=?2 WHERE device=?3 AND (capabilities<>?1 OR point_ids<>?2)",
       "writing a device"},
      {rows.rename_, "UPDATE device SET given_name=?, area=? WHERE row=?", "writing a device's name"},
      {rows.hear_, "UPDATE device SET last_heard=?1 WHERE row=?2 AND last_heard<?1", "writing a device"},
      {rows.remove_, "DELETE FROM device WHERE row=?", "forgetting a device"},
      {rows.remove_announcement_, "DELETE FROM announcement WHERE device=?", "forgetting a device"},
      {rows.stalest_,
       "SELECT row FROM device WHERE row<>? ORDER BY decision<>0 OR given_name||area<>'', last_heard, row LIMIT ?",
       "looking for devices to forget"},
      {rows.count_, "SELECT count(*) FROM device", "counting devices"},
      {rows.read_, std::string(kSelect) + "WHERE d.row=?", "reading a device"},
  };
  for (const auto& entry : entries) {
    auto statement = database.prepare(entry.sql.c_str(), entry.doing);
    if (!statement) return fail(statement.error());
    entry.statement = std::move(*statement);
  }
  return rows;
}

Result<std::optional<DeviceRows::Row>> DeviceRows::row_of(const std::string& network, const std::string& address) {
  Query query(row_of_);
  const auto row = query.text(network).text(address).next();
  if (!row) return fail(row.error());
  return *row ? std::optional(query.integer_at(0)) : std::nullopt;
}

Result<bool> DeviceRows::exists(Row row) {
  Query query(exists_);
  return query.integer(row).next();
}

Result<DeviceRows::Row> DeviceRows::insert(const KnownDevice& device, const AnnouncementBytes& announcement) {
  Query insert(insert_);
  insert.text(device.id).integer(static_cast<std::int64_t>(device.decision)).text(device.join.name);
  insert.text(device.join.id).time(device.first_seen).time(device.last_heard);
  insert.text(device.network).text(device.address).text(device.given_name).text(device.area);
  if (auto done = insert.run(); !done) return fail(done.error());
  const auto row = insert.last_row();
  Query rest(insert_announcement_);
  rest.blob(announcement.capabilities).blob(announcement.point_ids).integer(row);
  if (auto done = rest.run(); !done) return fail(done.error());
  return row;
}

Result<void> DeviceRows::update(Row row, const KnownDevice& device, const AnnouncementBytes& announcement) {
  Query update(update_);
  update.text(device.id).integer(static_cast<std::int64_t>(device.decision)).text(device.join.name);
  update.text(device.join.id).time(device.first_seen).time(device.last_heard).integer(row);
  update.text(device.given_name).text(device.area);
  if (auto done = update.run(); !done) return done;
  Query rest(update_announcement_);
  return rest.blob(announcement.capabilities).blob(announcement.point_ids).integer(row).run();
}

Result<void> DeviceRows::rename(Row row, const std::string& name, const std::string& area) {
  return Query(rename_).text(name).text(area).integer(row).run();
}

Result<void> DeviceRows::hear(Row row, WallTime heard) {
  return Query(hear_).time(heard).integer(row).run();
}

Result<void> DeviceRows::remove(Row row) {
  if (auto done = Query(remove_announcement_).integer(row).run(); !done) return done;
  return Query(remove_).integer(row).run();
}

Result<std::vector<DeviceRows::Row>> DeviceRows::stalest(Row except, std::int64_t count) {
  std::vector<Row> rows;
  Query query(stalest_);
  query.integer(except).integer(count);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return rows;
    rows.push_back(query.integer_at(0));
  }
}

Result<std::uint64_t> DeviceRows::count() {
  Query query(count_);
  const auto row = query.next();
  if (!row) return fail(row.error());
  return static_cast<std::uint64_t>(query.integer_at(0));
}

Result<void> DeviceRows::each(Database& database, const std::string& network, std::uint64_t& damaged,
                              const std::function<Result<void>(Row, KnownDevice&&)>& visit) const {
  const auto last = database.number("SELECT ifnull(max(row),0) FROM device", "reading devices");
  if (!last) return fail(last.error());
  // Has a statement of its own, as the visitor may call each() too.
  const auto sql = std::string(kSelect) + "WHERE d.row<=?1 AND (?2='' OR d.network=?2) ORDER BY d.row";
  auto statement = database.prepare(sql.c_str(), "reading devices");
  if (!statement) return fail(statement.error());
  AnnouncementReader announcements;
  Query query(*statement);
  query.integer(*last).text(network);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return {};
    auto device = device_at(query, announcements);
    if (!device) {
      ++damaged;
      continue;
    }
    if (auto done = visit(query.integer_at(0), std::move(*device)); !done) return done;
  }
}

Result<std::optional<KnownDevice>> DeviceRows::read(Row row, std::uint64_t& damaged) {
  AnnouncementReader announcements;
  Query query(read_);
  const auto there = query.integer(row).next();
  if (!there) return fail(there.error());
  if (!*there) return std::optional<KnownDevice>();
  auto device = device_at(query, announcements);
  if (!device) ++damaged;
  return device;
}

}  // namespace rubicon::state
