#include "web/files/folder_page.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "web/access/sha256.h"
#include "web/files/file_answer.h"

namespace rubicon::web::files {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = std::uintmax_t{16} << 20;

/// Nothing outside of the folder, where symbolic links may lead.
std::optional<std::string> read_below(const fs::path& folder, const std::string& name) {
  std::error_code error;
  const auto root = fs::canonical(folder, error);
  if (error) return std::nullopt;
  const auto path = fs::canonical(root / name, error);
  if (error || !path.string().starts_with(root.string() + "/")) return std::nullopt;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) > kLargestFile || error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return std::nullopt;
  return std::move(text).str();
}

}  // namespace

std::optional<Response> FolderPage::find(const Request& request) const {
  const auto name = name_in(request.path);
  const auto bytes = name.empty() ? std::nullopt : read_below(folder_, name);
  if (!bytes) return std::nullopt;
  const auto digest = access::sha256(*bytes);
  const auto hash = access::hex(digest.data(), digest.size());
  return answer(request, {.name = name, .bytes = *bytes, .hash = hash});
}

}  // namespace rubicon::web::files
