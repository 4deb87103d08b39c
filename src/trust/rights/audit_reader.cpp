#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "model/json_members.h"
#include "model/json_text.h"
#include "trust/rights/audit_file.h"

namespace rubicon::trust::rights {

namespace {

bool matches(const AuditQuery& query, const nlohmann::json& line) {
  const auto time = model::time_from_seconds(model::number_of(line, "t"));
  const bool is_in_time = query.from <= time && time < query.to;
  const bool is_of_name = query.who.empty() || model::text_of(line, "who") == query.who;
  return is_in_time && is_of_name && (!query.refused_only || model::text_of(line, "verdict") == "refused");
}

AuditRead read_one(std::istream& file, const AuditQuery& query,
                   const std::function<void(std::string_view line)>& call) {
  AuditRead read;
  for (std::string line; std::getline(file, line);) {
    if (!file.eof()) read.end += line.size() + 1;
    const auto tree = model::parse_json(line);
    if (!tree.is_object() || !tree.contains("t")) {
      read.damaged += line.empty() ? 0U : 1U;
    } else if (matches(query, tree)) {
      call(line);
    }
  }
  return read;
}

}  // namespace

Result<AuditRead> read_audit(const std::string& file, const AuditQuery& query,
                             const std::function<void(std::string_view line)>& call) {
  AuditRead all;
  bool any = false;
  for (int age = kOlderAuditFiles; age >= 0; --age) {
    const auto name = age == 0 ? file : fmt::format("{}.{}", file, age);
    errno = 0;
    std::ifstream lines(name, std::ios::binary);
    if (!lines && errno == ENOENT) continue;
    if (!lines) return fail(ErrorCode::kRefused, fmt::format("{}: cannot be read: {}", name, std::strerror(errno)));
    any = true;
    const auto one = read_one(lines, query, call);
    all = {all.damaged + one.damaged, age == 0 ? one.end : 0};
  }
  if (!any) return fail(ErrorCode::kNotFound, fmt::format("{}: there is no such file, expected an audit log", file));
  return all;
}

}  // namespace rubicon::trust::rights
