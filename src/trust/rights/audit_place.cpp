#include "trust/rights/audit_place.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <tuple>

namespace rubicon::trust::rights {

namespace {

namespace fs = std::filesystem;

/// The next `file`, until the others have their names.
std::string name_of_new(const std::string& file) {
  return file + ".new";
}

bool is_there(const std::string& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

Result<void> rename(const std::string& from, const std::string& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return {};
  return fail(ErrorCode::kRefused, fmt::format("{}: cannot be renamed to {}: {}", from, to, error.message()));
}

}  // namespace

void restore(const std::string& file) {
  std::error_code error;
  const bool is_left = fs::symlink_status(name_of_new(file), error).type() == fs::file_type::regular;
  if (!is_there(file) && is_left) std::ignore = rename(name_of_new(file), file);
}

Result<void> check_place(const std::string& file) {
  const auto other = name_of_new(file);
  if (auto done = rename(file, other); !done)
    return fail(done.error().code,
                done.error().text + "; expected a place for an audit, which keeps its older lines in further files");
  return rename(other, file);
}

Result<base::OwnFile> rotate(const std::string& file, int older) {
  auto made = base::OwnFile::open(name_of_new(file), O_WRONLY | O_APPEND | O_TRUNC);
  if (!made) return made;
  const auto name = [&](int age) { return age == 0 ? file : fmt::format("{}.{}", file, age); };
  for (int age = older; age > 0 && is_there(file); --age) {
    if (!is_there(name(age - 1))) continue;
    if (auto done = rename(name(age - 1), name(age)); !done) return fail(std::move(done.error()));
  }
  if (auto done = rename(name_of_new(file), file); !done) return fail(std::move(done.error()));
  return made;
}

}  // namespace rubicon::trust::rights
