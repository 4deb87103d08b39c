#include "networks/knx/project/project_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/project/project_documents.h"
#include "networks/knx/secure/passwords.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::project {

namespace {

constexpr std::string_view kMaster = "knx_master.xml";
constexpr std::size_t kMaxId = 32;

/// `P-0242` of `P-0242/0.xml`, `P-0242.zip`, `P-0242.signature`; empty for other names.
std::string project_of(std::string_view name) {
  if (!name.starts_with("P-")) return {};
  const auto id = name.substr(0, name.find_first_of("/."));
  return id.size() < name.size() && id.size() <= kMaxId ? std::string(id) : std::string();
}

}  // namespace

Result<ProjectFile> ProjectFile::open(std::unique_ptr<transport::FileSource> file, const ReadOptions& options) {
  auto archive = Archive::open(std::move(file), options.limits);
  if (!archive) return fail(archive.error());
  ProjectFile project(std::move(*archive));
  if (auto found = project.find_schema(); !found) return fail(found.error());
  if (auto found = project.find_project(); !found) return fail(found.error());
  if (auto unlocked = project.unlock(options); !unlocked) return fail(unlocked.error());
  return project;
}

Result<void> ProjectFile::find_schema() {
  SchemaDocument master;
  auto read = read_entry(std::string(kMaster), master);
  if (!read && read.error().code == ErrorCode::kNotFound)
    return fail(ErrorCode::kInvalid, fmt::format("has no entry {}, expected a project of ETS (.knxproj)", kMaster));
  if (!read) return read;
  const auto schema = master.schema();
  if (!schema || *schema < kOldestSchema)
    return fail(ErrorCode::kInvalid,
                fmt::format("{} has the schema {}, expected http://knx.org/xml/project/{} to {} (ETS 4 to 6)", kMaster,
                            model::quoted(master.name_space()), kOldestSchema, kNewestSchema));
  schema_ = *schema;
  return {};
}

Result<void> ProjectFile::find_project() {
  std::set<std::string> ids;
  for (const auto& entry : outer_.entries()) {
    if (auto id = project_of(entry.name); !id.empty()) ids.insert(std::move(id));
  }
  if (ids.empty())
    return fail(ErrorCode::kInvalid, "has no project: expected a folder P-..., or P-....zip in the archive");
  if (ids.size() > 1)
    return fail(ErrorCode::kInvalid,
                fmt::format("has the projects {} and {}, expected one", *ids.begin(), *std::next(ids.begin())));
  id_ = *ids.begin();
  return {};
}

Result<void> ProjectFile::unlock(const ReadOptions& options) {
  const auto* inner = outer_.find(id_ + ".zip");
  if (inner == nullptr) return {};
  auto opened = outer_.open_inner(*inner);
  if (!opened) return fail(opened.error());
  inner_ = std::move(*opened);
  const auto* entry = part("0.xml");
  if (entry == nullptr || entry->protection == Archive::Protection::kNone) return {};
  if (options.password == nullptr || options.password->empty())
    return fail(ErrorCode::kRefused, fmt::format("the project {} is protected by a password, and none was given", id_));
  if (options.password->text().find('\0') != std::string_view::npos)
    return fail(ErrorCode::kRefused, "the password has a zero byte, expected text");
  if (entry->protection != Archive::Protection::kAes) {
    password_ = *options.password;
    return {};
  }
  auto derived = secure::archive_password(*options.password);  // ETS 6
  if (!derived) return fail(derived.error());
  password_ = std::move(*derived);
  return {};
}

const Archive::Entry* ProjectFile::part(std::string_view name) const {
  const auto& archive = inner_ ? *inner_ : outer_;
  const auto wanted = inner_ ? std::string(name) : fmt::format("{}/{}", id_, name);
  const auto found = std::find_if(archive.entries().begin(), archive.entries().end(), [&](const auto& entry) {
    return groups::to_lower(entry.name) == groups::to_lower(wanted);  // ETS 4: Project.xml
  });
  return found == archive.entries().end() ? nullptr : &*found;
}

Result<void> ProjectFile::read_part(std::string_view name, Document& document) const {
  const auto* entry = part(name);
  if (entry == nullptr) return fail(ErrorCode::kInvalid, fmt::format("the project {} has no entry {}", id_, name));
  auto read = document.read(inner_ ? *inner_ : outer_, *entry, is_protected() ? &password_ : nullptr);
  if (read || !inner_) return read;
  const auto& error = read.error();
  if (is_protected() && error.code == ErrorCode::kRefused)
    return fail(error.code, fmt::format("the password of the project {} is wrong", id_));
  if (is_protected() && error.code == ErrorCode::kInvalid)
    return fail(ErrorCode::kRefused,
                fmt::format("the password of the project {} is wrong, or the file is damaged ({}.zip: {})", id_, id_,
                            error.text));
  return fail(error.code, fmt::format("{}.zip: {}", id_, error.text));
}

Result<void> ProjectFile::read_entry(const std::string& name, Document& document) const {
  const auto* entry = outer_.find(name);
  if (entry == nullptr) return fail(ErrorCode::kNotFound, fmt::format("has no entry {}", model::quoted(name)));
  return document.read(outer_, *entry, nullptr);
}

}  // namespace rubicon::networks::knx::project
