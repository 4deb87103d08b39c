#include "base/config_reader.h"

#include <map>
#include <string_view>

#include <fmt/format.h>

#include "base/assert.h"

namespace rubicon::base {

std::string to_string(const ConfigPlace& place) {
  const std::string_view file = place.file ? std::string_view(*place.file) : std::string_view();
  if (place.line == 0) return std::string(file);
  return fmt::format("{}:{}:{}", file, place.line, place.column);
}

ConfigNode::ConfigNode() = default;
ConfigNode::~ConfigNode() = default;
ConfigNode::ConfigNode(const ConfigNode&) = default;
ConfigNode& ConfigNode::operator=(const ConfigNode&) = default;
ConfigNode::ConfigNode(ConfigNode&&) noexcept = default;
ConfigNode& ConfigNode::operator=(ConfigNode&&) noexcept = default;

const ConfigNode* ConfigNode::find(std::string_view key) const {
  for (const auto& [name, node] : entries) {
    if (name == key) return &node;
  }
  return nullptr;
}

ConfigNode* ConfigNode::find(std::string_view key) {
  return const_cast<ConfigNode*>(std::as_const(*this).find(key));
}

ConfigPlace ConfigNode::key_place() const {
  return key_line == 0 ? place : ConfigPlace(place.file, key_line, key_column);
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

namespace {

/// Base 128, the low bits first.
void put_count(std::string& out, std::size_t count) {
  for (; count >= 0x80; count >>= 7U) out += static_cast<char>(count | 0x80U);
  out += static_cast<char>(count);
}

void put_text(std::string& out, std::string_view text) {
  put_count(out, text.size());
  out += text;
}

void pack(std::string& out, const ConfigNode& node) {
  out += static_cast<char>(static_cast<unsigned>(node.kind) | (node.was_quoted ? 4U : 0U));
  switch (node.kind) {
    case ConfigNode::Kind::kNull: return;
    case ConfigNode::Kind::kScalar: return put_text(out, node.text);
    case ConfigNode::Kind::kList:
      put_count(out, node.items.size());
      for (const auto& item : node.items) pack(out, item);
      return;
    case ConfigNode::Kind::kMap:
      put_count(out, node.entries.size());
      for (const auto& [key, entry] : node.entries) {
        put_text(out, key);
        pack(out, entry);
      }
  }
}

class Unpacking {
 public:
  explicit Unpacking(std::string_view text) : text_(text) {}

  ConfigNode node() {
    ConfigNode node;
    const auto head = byte();
    node.kind = static_cast<ConfigNode::Kind>(head & 3U);
    node.was_quoted = (head & 4U) != 0;
    if (node.kind == ConfigNode::Kind::kScalar) node.text = piece();
    if (node.kind == ConfigNode::Kind::kList) {
      for (auto left = count(); left > 0; --left) node.items.push_back(this->node());
    }
    if (node.kind == ConfigNode::Kind::kMap) {
      for (auto left = count(); left > 0; --left) {
        std::string key(piece());
        node.entries.emplace_back(std::move(key), this->node());
      }
    }
    return node;
  }

 private:
  unsigned byte() {
    RUBICON_ASSERT(!text_.empty());
    const auto first = static_cast<unsigned char>(text_.front());
    text_.remove_prefix(1);
    return first;
  }
  std::size_t count() {
    std::size_t number = 0;
    for (unsigned shift = 0;; shift += 7) {
      const auto next = byte();
      number |= static_cast<std::size_t>(next & 0x7fU) << shift;
      if (next < 0x80) return number;
    }
  }
  std::string_view piece() {
    const auto size = count();
    RUBICON_ASSERT(size <= text_.size());
    const auto taken = text_.substr(0, size);
    text_.remove_prefix(size);
    return taken;
  }

  std::string_view text_;
};

}  // namespace

std::string packed(const ConfigNode& node) {
  std::string out;
  pack(out, node);
  return out;
}

ConfigNode unpacked(std::string_view packed) {
  return Unpacking(packed).node();
}

}  // namespace rubicon::base
