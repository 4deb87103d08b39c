#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "model/key.h"
#include "runtime/island_config.h"
#include "runtime/yaml.h"

namespace rubicon::runtime {

namespace {

Result<std::string> read_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: {}", path, error ? error.message() : std::string("not a regular file")));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  std::string text(kMaxYamlBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return fail(ErrorCode::kIo, fmt::format("{}: reading failed", path));
  if (!file.eof() && file)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: larger than {} bytes", path, kMaxYamlBytes));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

ConfigNode& child(ConfigNode& map, const std::string& key, const std::string& shown_as) {
  for (auto& [name, node] : map.entries) {
    if (name == key) return node;
  }
  ConfigNode fresh;
  fresh.place = {shown_as, 0, 0};
  return map.entries.emplace_back(key, std::move(fresh)).second;
}

}  // namespace

Result<void> apply_override(ConfigNode& root, std::string_view assignment) {
  const auto shown_as = fmt::format("--set {}", assignment.substr(0, 100));
  const auto equals = assignment.find('=');
  if (equals == assignment.npos || equals == 0) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected KEY.KEY...=VALUE", shown_as));
  }
  auto value = parse_yaml_value(assignment.substr(equals + 1), shown_as);
  if (!value) return fail(value.error());
  ConfigNode* node = &root;
  for (const auto part : model::key_parts(assignment.substr(0, equals))) {
    if (part.empty()) return fail(ErrorCode::kInvalid, fmt::format("{}: empty part in the path", shown_as));
    if (node->kind == ConfigNode::Kind::kNull) node->kind = ConfigNode::Kind::kMap;
    if (node->kind != ConfigNode::Kind::kMap) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: '{}' lies in something that is not a map", shown_as, part));
    }
    node = &child(*node, std::string(part), shown_as);
  }
  *node = std::move(*value);
  return {};
}

Result<ConfigNode> load_config(const std::string& path, const std::vector<std::string>& overrides) {
  const auto text = read_file(path);
  if (!text) return fail(text.error());
  auto root = parse_yaml(*text, path);
  if (!root) return root;
  for (const auto& assignment : overrides) {
    if (auto applied = apply_override(*root, assignment); !applied) return fail(applied.error());
  }
  return root;
}

}  // namespace rubicon::runtime
