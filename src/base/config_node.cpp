#include "base/config_node.h"

#include <map>
#include <string_view>

#include <fmt/format.h>

namespace rubicon::base {

std::string to_string(const ConfigPlace& place) {
  if (place.line == 0) return place.file;
  return fmt::format("{}:{}:{}", place.file, place.line, place.column);
}

ConfigNode::ConfigNode() = default;
ConfigNode::~ConfigNode() = default;
ConfigNode::ConfigNode(const ConfigNode&) = default;
ConfigNode& ConfigNode::operator=(const ConfigNode&) = default;
ConfigNode::ConfigNode(ConfigNode&&) noexcept = default;
ConfigNode& ConfigNode::operator=(ConfigNode&&) noexcept = default;

const ConfigNode* ConfigNode::find(const std::string& key) const {
  for (const auto& [name, node] : entries) {
    if (name == key) return &node;
  }
  return nullptr;
}

namespace {

/// Writes down differing paths until it has enough of them.
class Comparison {
 public:
  explicit Comparison(std::size_t limit) : limit_(limit) {}

  void compare(const ConfigNode& before, const ConfigNode& now, const std::string& path) {
    if (found.size() >= limit_) return;
    const bool lists = now.kind == ConfigNode::Kind::kList && before.items.size() == now.items.size();
    const bool maps = now.kind == ConfigNode::Kind::kMap;
    if (before.kind != now.kind || (now.kind == ConfigNode::Kind::kList && !lists) ||
        (!lists && !maps && (before.text != now.text || before.was_quoted != now.was_quoted))) {
      found.push_back(path);
      return;
    }
    for (std::size_t i = 0; lists && i < now.items.size(); ++i) {
      compare(before.items[i], now.items[i], path + "[" + std::to_string(i) + "]");
    }
    if (maps) compare_entries(before, now, path.empty() ? path : path + ".");
  }

  std::vector<std::string> found;

 private:
  void compare_entries(const ConfigNode& before, const ConfigNode& now, const std::string& prefix) {
    std::map<std::string_view, const ConfigNode*> old;
    for (const auto& [key, node] : before.entries) old.emplace(key, &node);
    for (const auto& [key, node] : now.entries) {
      const auto twin = old.find(key);
      if (twin == old.end()) {
        note(prefix + key);
        continue;
      }
      compare(*twin->second, node, prefix + key);
      old.erase(twin);
    }
    for (const auto& [key, node] : old) note(prefix + std::string(key));
  }

  void note(std::string path) {
    if (found.size() < limit_) found.push_back(std::move(path));
  }

  std::size_t limit_;
};

}  // namespace

std::vector<std::string> differences(const ConfigNode& before, const ConfigNode& now, std::size_t limit) {
  Comparison comparison(limit);
  comparison.compare(before, now, {});
  return std::move(comparison.found);
}

}  // namespace rubicon::base
