#include "state/rows.h"

#include <cmath>
#include <optional>
#include <utility>

#include "model/type_names.h"

namespace rubicon::state {

namespace {

/// The alternatives of model::Value in the column `form`; the numbers must not change.
enum class Form : std::uint8_t { kNothing, kBoolean, kInteger, kReal, kText, kJson };

struct ValueBinder {
  Query& query;

  void operator()(std::monostate) const { form(Form::kNothing).null(); }
  void operator()(bool on) const { form(Form::kBoolean).integer(on ? 1 : 0); }
  void operator()(std::int64_t number) const { form(Form::kInteger).integer(number); }
  void operator()(double number) const {
    if (!std::isfinite(number)) return (*this)(std::monostate{});  // tuples have neither infinity nor NaN
    form(Form::kReal).real(number);
  }
  void operator()(const std::string& text) const { form(Form::kText).text(text); }
  void operator()(const model::Json& json) const { form(Form::kJson).text(json.text); }

 private:
  Query& form(Form form) const { return query.integer(static_cast<std::int64_t>(form)); }
};

void bind_content(Query& query, const StoredValue& value) {
  std::visit(ValueBinder{query}, value.value);
  query.time(value.heard).time(value.changed).time(value.user_time);
  query.integer(value.set_by_user ? 1 : 0);
}

void bind_point(Query& query, StateStore::Row device, const model::PointId& point) {
  query.integer(device).integer(static_cast<std::int64_t>(point.kind));
  query.integer(static_cast<std::int64_t>(point.type)).text(point.instance);
}

std::optional<model::Value> value_at(const Query& query, int form_column, int column) {
  const auto type = query.type_of(column);
  switch (query.integer_at(form_column)) {
    case static_cast<int>(Form::kNothing):
      if (type == SQLITE_NULL) return model::Value{};
      break;
    case static_cast<int>(Form::kBoolean):
      if (type == SQLITE_INTEGER) return query.integer_at(column) != 0;
      break;
    case static_cast<int>(Form::kInteger):
      if (type == SQLITE_INTEGER) return query.integer_at(column);
      break;
    case static_cast<int>(Form::kReal):
      if (type == SQLITE_FLOAT) return query.real_at(column);
      break;
    case static_cast<int>(Form::kText):
      if (type == SQLITE_TEXT) return std::string(query.text_at(column));
      break;
    case static_cast<int>(Form::kJson):
      if (type == SQLITE_TEXT) return model::Json{std::string(query.text_at(column))};
      break;
    default: break;
  }
  return std::nullopt;
}

std::optional<StoredValue> stored_value_at(const Query& query) {
  const auto kind = query.integer_at(0);
  const auto type = query.integer_at(1);
  auto value = value_at(query, 3, 4);
  if (!value || kind < 0 || kind > static_cast<int>(Kind::kProperty) || type < 0 || type > UINT16_MAX) {
    return std::nullopt;
  }
  StoredValue out;
  out.point = model::current_point(
      {static_cast<Kind>(kind), TypeId(static_cast<std::uint16_t>(type)), std::string(query.text_at(2))});
  out.value = std::move(*value);
  out.heard = query.time_at(5);
  out.changed = query.time_at(6);
  out.user_time = query.time_at(7);
  out.set_by_user = query.integer_at(8) != 0;
  return out;
}

struct TextSize {
  std::size_t operator()(const std::string& text) const { return text.size(); }
  std::size_t operator()(const model::Json& json) const { return json.text.size(); }
  template <class Number>
  std::size_t operator()(const Number&) const {
    return 0;
  }
};

}  // namespace

Result<ValueRows> ValueRows::prepare(Database& database) {
  struct Entry {
    Statement& statement;
    const char* sql;
    const char* doing;
  };
  ValueRows rows;
  for (const auto& entry : {
           Entry{rows.update_,
                 "UPDATE value SET form=?1, value=?2, heard=?3, changed=?4, user_time=?5, set_by_user=?6 "
                 "WHERE device=?7 AND kind=?8 AND type=?9 AND instance=?10",
                 "writing a value"},
           Entry{rows.insert_,
                 "INSERT INTO value(form,value,heard,changed,user_time,set_by_user,device,kind,type,instance) "
                 "VALUES(?,?,?,?,?,?,?,?,?,?)",
                 "writing a value"},
           Entry{rows.remove_, "DELETE FROM value WHERE device=?", "forgetting values"},
           Entry{rows.select_,
                 "SELECT kind,type,instance,form,value,heard,changed,user_time,set_by_user FROM value WHERE device=? "
                 "ORDER BY kind,type,instance",
                 "reading values"},
           Entry{rows.count_, "SELECT count(*) FROM value", "counting values"},
       }) {
    auto statement = database.prepare(entry.sql, entry.doing);
    if (!statement) return fail(statement.error());
    entry.statement = std::move(*statement);
  }
  return rows;
}

Result<bool> ValueRows::put(StateStore::Row device, const StoredValue& value) {
  {
    Query update(update_);
    bind_content(update, value);
    bind_point(update, device, value.point);
    if (auto done = update.run(); !done) return fail(done.error());
    if (update.changes() > 0) return false;
  }
  Query insert(insert_);
  bind_content(insert, value);
  bind_point(insert, device, value.point);
  if (auto done = insert.run(); !done) return fail(done.error());
  return true;
}

Result<std::uint64_t> ValueRows::remove(StateStore::Row device) {
  Query query(remove_);
  if (auto done = query.integer(device).run(); !done) return fail(done.error());
  return static_cast<std::uint64_t>(query.changes());
}

Result<std::vector<StoredValue>> ValueRows::of(StateStore::Row device, std::uint64_t& damaged) {
  std::vector<StoredValue> values;
  Query query(select_);
  query.integer(device);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return values;
    if (auto value = stored_value_at(query)) {
      values.push_back(std::move(*value));
    } else {
      ++damaged;
    }
  }
}

Result<std::uint64_t> ValueRows::count() {
  Query query(count_);
  const auto row = query.next();
  if (!row) return fail(row.error());
  return static_cast<std::uint64_t>(query.integer_at(0));
}

std::size_t ValueRows::size_of(const StoredValue& value) {
  return std::visit(TextSize{}, value.value) + value.point.instance.size();
}

Result<MemoryRows> MemoryRows::prepare(Database& database) {
  MemoryRows rows;
  const auto make = [&database](Statement& into, const char* sql, const char* doing) -> Result<void> {
    auto statement = database.prepare(sql, doing);
    if (!statement) return fail(statement.error());
    into = std::move(*statement);
    return {};
  };
  constexpr const char* kWriting = "writing what a network remembers";
  constexpr const char* kReading = "reading what a network remembers";
  if (auto done = make(rows.put_, "INSERT OR REPLACE INTO memory(network,name,value) VALUES(?,?,?)", kWriting); !done)
    return fail(done.error());
  if (auto done = make(rows.remove_, "DELETE FROM memory WHERE network=? AND name=?", kWriting); !done)
    return fail(done.error());
  if (auto done = make(rows.find_, "SELECT value FROM memory WHERE network=? AND name=?", kReading); !done)
    return fail(done.error());
  if (auto done = make(rows.count_, "SELECT count(*) FROM memory WHERE network=? AND name<>?", kReading); !done)
    return fail(done.error());
  if (auto done =
          make(rows.sizes_, "SELECT network,count(*),sum(length(value)) FROM memory GROUP BY network ORDER BY network",
               kReading);
      !done)
    return fail(done.error());
  if (auto done = make(rows.remove_all_, "DELETE FROM memory WHERE network=?", kWriting); !done)
    return fail(done.error());
  return rows;
}

Result<void> MemoryRows::put(std::string_view network, std::string_view name, ByteView value) {
  Query query(put_);
  return query.text(network).text(name).blob(value).run();
}

Result<void> MemoryRows::remove(std::string_view network, std::string_view name) {
  Query query(remove_);
  return query.text(network).text(name).run();
}

Result<std::optional<Bytes>> MemoryRows::find(std::string_view network, std::string_view name) {
  Query query(find_);
  const auto row = query.text(network).text(name).next();
  if (!row) return fail(row.error());
  if (!*row) return std::optional<Bytes>();
  const auto value = query.blob_at(0);
  return Bytes(value.begin(), value.end());
}

Result<std::uint64_t> MemoryRows::count_others(std::string_view network, std::string_view name) {
  Query query(count_);
  const auto row = query.text(network).text(name).next();
  if (!row) return fail(row.error());
  return static_cast<std::uint64_t>(query.integer_at(0));
}

Result<std::vector<MemorySize>> MemoryRows::sizes() {
  std::vector<MemorySize> all;
  Query query(sizes_);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return all;
    all.push_back({std::string(query.text_at(0)), static_cast<std::uint64_t>(query.integer_at(1)),
                   static_cast<std::uint64_t>(query.integer_at(2))});
  }
}

Result<bool> MemoryRows::remove_all(std::string_view network) {
  Query query(remove_all_);
  if (auto done = query.text(network).run(); !done) return fail(done.error());
  return query.changes() > 0;
}

}  // namespace rubicon::state
