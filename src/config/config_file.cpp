#include "config/config_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "base/text.h"
#include "config/yaml.h"
#include "rubicon/key.hpp"

namespace rubicon::config {

namespace {

Result<std::string> read_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: {}", path, error ? error.message() : std::string("not a regular file")));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kIo, fmt::format("{}: {}", path, std::strerror(errno)));
  std::string text;
  std::string piece(65536, '\0');
  while (text.size() <= kMaxYamlBytes &&
         file.read(piece.data(), static_cast<std::streamsize>(piece.size())).gcount() > 0)
    text.append(piece, 0, static_cast<std::size_t>(file.gcount()));
  if (file.bad()) return fail(ErrorCode::kIo, fmt::format("{}: reading failed", path));
  if (text.size() > kMaxYamlBytes)
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: larger than {} bytes", path, kMaxYamlBytes));
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

/// `networks.knx-hall.devices."1.4.6".name=...`: the parts before the equals sign, dots inside quotes kept, and the
/// text behind it. No parts: there is no equals sign, or a part is empty.
struct Assignment {
  std::vector<std::string> path;
  std::string_view value;
};

Assignment split(std::string_view text) {
  Assignment split{{""}, {}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') {
      quoted = !quoted;
    } else if (quoted || (text[i] != '.' && text[i] != '=')) {
      split.path.back() += text[i];
    } else if (split.path.back().empty()) {
      return {};
    } else if (text[i] == '.') {
      split.path.emplace_back();
    } else {
      split.value = text.substr(i + 1);
      return split;
    }
  }
  return {};
}

}  // namespace

Result<void> apply_override(ConfigNode& root, std::string_view assignment) {
  const auto shown_as = fmt::format("--set {}", model::quoted(assignment));
  const auto [path, text] = split(assignment);
  if (path.empty()) return fail(ErrorCode::kInvalid, fmt::format("{}: expected KEY.KEY...=VALUE", shown_as));
  auto value = parse_yaml_value(text, shown_as);
  if (!value) return fail(value.error());
  if (path.front() == "networks") number_networks(root);  // --set names those of a list by their ids
  ConfigNode* node = &root;
  for (const auto& part : path) {
    if (node->kind == ConfigNode::Kind::kNull) node->kind = ConfigNode::Kind::kMap;
    if (node->kind != ConfigNode::Kind::kMap) {
      return fail(ErrorCode::kInvalid, fmt::format("{}: '{}' lies in something that is not a map", shown_as, part));
    }
    node = &child(*node, part, shown_as);
  }
  *node = std::move(*value);
  return {};
}

Result<ConfigNode> load_config(const std::string& path, const std::vector<std::string>& overrides) {
  const auto text = read_file(path);
  if (!text) return fail(text.error());
  auto root = parse_yaml(*text, path);
  if (!root) return root;
  std::vector<std::string> wrong;
  for (const auto& assignment : overrides) {
    if (auto applied = apply_override(*root, assignment); !applied) wrong.push_back(applied.error().text);
  }
  if (!wrong.empty()) return fail(ErrorCode::kInvalid, fmt::format("{}", fmt::join(wrong, "\n")));
  return root;
}

void number_networks(ConfigNode& root) {
  auto* networks = root.find("networks");
  if (!networks || networks->kind != ConfigNode::Kind::kList) return;
  std::map<std::string, std::size_t> numbers;
  std::size_t place = 0;
  for (auto& item : std::exchange(networks->items, {})) {
    ++place;
    const auto* type = std::as_const(item).find("type");
    const bool typed = type && !type->text.empty();
    auto id = typed ? fmt::format("{}-{}", type->text, ++numbers[type->text]) : fmt::format("network-{}", place);
    networks->entries.emplace_back(std::move(id), std::move(item));
  }
  networks->kind = ConfigNode::Kind::kMap;
}

namespace {

model::DataType data_type(ConfigReader& type) {
  using model::DataType;
  const auto word = type.choice("data", "real", {"boolean", "integer", "real", "enumeration", "text", "json", "bytes"});
  for (const auto data : {DataType::kBoolean, DataType::kInteger, DataType::kReal, DataType::kEnumeration,
                          DataType::kText, DataType::kJson, DataType::kBytes}) {
    if (to_string(data) == word) return data;
  }
  return DataType::kReal;
}

/// `id: 0x8001` or decimal.
std::uint16_t type_id(ConfigReader& type) {
  const auto text = type.required_text("id", "0x8000..0xffff, such as 0x8001");
  const auto id = text.starts_with("0x") ? base::parse_hex_number<std::uint16_t>(std::string_view(text).substr(2))
                                         : base::parse_number<std::uint16_t>(text);
  if (id) return *id;
  if (type.has("id")) type.error("id", "expected 0x8000..0xffff");
  return model::kFirstSiteType;
}

}  // namespace

void read_site_types(ConfigReader& root, TypeCatalogue& types) {
  for (auto& [name, type] : root.maps("types")) {
    model::SiteType site;
    site.id = type_id(type);
    site.name = name;
    site.quantity = type.text("quantity", name);
    site.unit = type.text("unit", "1");
    site.data = data_type(type);
    site.minimum = type.real("minimum", site.minimum, -1e300, 1e300);
    site.maximum = type.real("maximum", site.maximum, -1e300, 1e300);
    site.report =
        type.choice("report", "state", {"state", "event"}) == "event" ? model::Report::kEvent : model::Report::kState;
    site.words = fmt::format("{}", fmt::join(type.texts("words"), ","));
    type.finish();
    if (auto declared = types.declare(site); !declared) type.error("", declared.error().text);
  }
}

}  // namespace rubicon::config
