#include "history/store_sql.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::history {

using sqlite::Query;
using sqlite::Statement;

Result<void> prepare_statements(sqlite::Database& database, StoreStatements& statements, bool has_areas) {
  struct Text {
    Statement StoreStatements::*statement;
    const char *sql, *doing;
  };
  constexpr const char* kBlocks = "writing a block";
  for (const auto& text : {
           Text{&StoreStatements::insert_series, "INSERT INTO series(owner,key,kind,unit,words) VALUES(?,?,?,?,?)",
                "writing a series"},
           Text{&StoreStatements::update_series, "UPDATE series SET kind=?,unit=?,words=? WHERE id=?",
                "writing a series"},
           Text{&StoreStatements::insert_journal, "INSERT INTO journal VALUES(?,?,?)", "writing its journal"},
           Text{&StoreStatements::trim_journal, "DELETE FROM journal WHERE id<?", "shortening its journal"},
           Text{&StoreStatements::last_block,
                "SELECT start,part,until,count,gaps,data FROM block WHERE series=? ORDER BY start DESC,part DESC LIMIT "
                "1",
                kBlocks},
           Text{&StoreStatements::next_part, "SELECT coalesce(max(part)+1,0) FROM block WHERE series=? AND start=?",
                kBlocks},
           Text{&StoreStatements::insert_block,
                has_areas ? "INSERT INTO block VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
                          : "INSERT INTO block VALUES(?,?,?,?,?,?,?,?,?,?,?)",
                kBlocks},
           Text{&StoreStatements::delete_block, "DELETE FROM block WHERE series=? AND start=? AND part=?", kBlocks},
           Text{&StoreStatements::insert_text, "INSERT OR REPLACE INTO text VALUES(?,?,?)", "writing a text"},
           Text{&StoreStatements::put_meta, "INSERT OR REPLACE INTO meta VALUES(?,?)", "writing its times"},
       }) {
    auto prepared = database.prepare(text.sql, text.doing);
    if (!prepared) return fail(prepared.error());
    statements.*text.statement = std::move(*prepared);
  }
  return {};
}

Result<std::optional<std::int64_t>> Store::meta(const char* name) {
  auto statement = file_.database.prepare("SELECT value FROM meta WHERE name=?", "reading its times");
  if (!statement) return fail(statement.error());
  Query query(*statement);
  const auto there = query.text(name).next();
  if (!there) return fail(there.error());
  return *there ? std::optional(query.integer_at(0)) : std::nullopt;
}

Result<void> Store::put_meta(const char* name, std::int64_t value) {
  return Query(sql_.put_meta).text(name).integer(value).run();
}

Result<bool> Store::remove_if_empty(SeriesRow row) {
  if (!series_.at(row).open.empty()) return false;
  // The row with the highest id stays: SQLite would give the id to the next series, and the journal may still name it.
  auto remove = file_.database.prepare(
      "DELETE FROM series WHERE id=?1 AND id<(SELECT max(id) FROM series) AND NOT EXISTS(SELECT 1 FROM block WHERE "
      "series=?1) AND NOT EXISTS(SELECT 1 FROM hour WHERE series=?1) AND NOT EXISTS(SELECT 1 FROM text WHERE "
      "series=?1)",
      "removing a series");
  if (!remove) return fail(remove.error());
  Query query(*remove);
  if (auto done = query.integer(row).run(); !done) return fail(done.error());
  return query.changes() > 0;
}

void Store::forget(SeriesRow row) {
  const auto known = series_.find(row);
  if (known == series_.end()) return;
  names_.erase(known->second.declaration.name);
  series_.erase(known);
  for (auto& slot : slots_) {
    if (slot.row == row) slot.row = 0;
  }
}

std::string words_to_text(const std::vector<std::string>& words) {
  return model::dump(nlohmann::json(words));
}

std::vector<std::string> words_from_text(std::string_view text) {
  const auto tree = model::parse_json(text);
  std::vector<std::string> words;
  if (!tree.is_array()) return words;
  for (const auto& word : tree) {
    if (!word.is_string()) return {};
    words.push_back(word.get<std::string>());
  }
  return words;
}

}  // namespace rubicon::history
