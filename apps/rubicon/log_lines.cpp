#include "apps/rubicon/log_lines.h"

#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::cli {

std::vector<LogLine> log_lines_in(const tuples::TupleView& tuple) {
  std::vector<LogLine> lines;
  const auto list = model::parse_json(tuple.value);
  if (!list.is_array()) return lines;
  for (const auto& one : list) {
    lines.push_back({tuple.owner, model::count_of(one, "number"), model::time_of(one, "time"),
                     model::text_of(one, "level"), model::text_of(one, "subject"), model::text_of(one, "text")});
  }
  return lines;
}

}  // namespace rubicon::cli
