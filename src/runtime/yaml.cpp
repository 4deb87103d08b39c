#include "runtime/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>
#include <yaml-cpp/yaml.h>

#include <istream>
#include <set>
#include <streambuf>
#include <vector>

#include "base/config_reader.h"
#include "model/key.h"

namespace rubicon::runtime {

namespace {

constexpr std::size_t kMaxErrors = 100;

class ViewBuffer final : public std::streambuf {
 public:
  explicit ViewBuffer(std::string_view text) {
    auto* begin = const_cast<char*>(text.data());  // setg wants it mutable; an input buffer never writes
    setg(begin, begin, begin + text.size());
  }
};

/// Builds the tree from the parser's events. After an error it only listens, so that nothing grows any more.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string_view file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { leaf(mark, ConfigNode::Kind::kNull, {}, false); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    stop(mark, "aliases (*name) are not supported; write the value out");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& value) override {
    const bool quoted = tag == "!";
    const bool null = !quoted && (value.empty() || value == "~" || value == "null");
    leaf(mark, null ? ConfigNode::Kind::kNull : ConfigNode::Kind::kScalar, value, quoted);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, ConfigNode::Kind::kList);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, ConfigNode::Kind::kMap);
  }
  void OnMapEnd() override { close(); }

  base::ConfigErrors errors;
  ConfigNode root;

 private:
  struct Level {
    ConfigNode node;
    std::string key;
    bool has_key = false;
    std::set<std::string> keys;
  };

  ConfigPlace place(const YAML::Mark& mark) const { return {std::string(file_), mark.line + 1, mark.column + 1}; }

  void stop(const YAML::Mark& mark, std::string_view why) {
    if (!stopped_) errors.add(place(mark), "", why);
    stopped_ = true;
  }

  bool count(const YAML::Mark& mark) {
    if (++nodes_ > kMaxYamlNodes) stop(mark, fmt::format("more than {} values in one file", kMaxYamlNodes));
    return !stopped_;
  }

  void leaf(const YAML::Mark& mark, ConfigNode::Kind kind, const std::string& text, bool quoted) {
    if (!count(mark)) return;
    auto* level = levels_.empty() ? nullptr : &levels_.back();
    if (level && level->node.kind == ConfigNode::Kind::kMap && !level->has_key) return take_key(mark, *level, text);
    ConfigNode node;
    node.kind = kind;
    node.place = place(mark);
    node.text = text;
    node.was_quoted = quoted;
    put(std::move(node));
  }

  void take_key(const YAML::Mark& mark, Level& level, const std::string& text) {
    level.key = text;
    level.has_key = true;
    ConfigNode key;
    key.kind = ConfigNode::Kind::kScalar;
    key.place = place(mark);
    key.text = text;
    level.node.items.push_back(std::move(key));
    if (!level.keys.insert(text).second) {
      errors.add(place(mark), "", fmt::format("key {} stands twice in this map", model::quoted(text)));
      if (errors.lines().size() >= kMaxErrors) stopped_ = true;
    }
  }

  void open(const YAML::Mark& mark, ConfigNode::Kind kind) {
    if (!count(mark)) return;
    if (!levels_.empty() && levels_.back().node.kind == ConfigNode::Kind::kMap && !levels_.back().has_key) {
      return stop(mark, "a key must be one value, not a list or a map");
    }
    Level level;
    level.node.kind = kind;
    level.node.place = place(mark);
    levels_.push_back(std::move(level));
  }

  void close() {
    if (stopped_) return;
    auto node = std::move(levels_.back().node);
    levels_.pop_back();
    put(std::move(node));
  }

  void put(ConfigNode node) {
    if (levels_.empty()) {
      root = std::move(node);
      return;
    }
    auto& level = levels_.back();
    if (level.node.kind == ConfigNode::Kind::kList) {
      level.node.items.push_back(std::move(node));
      return;
    }
    level.node.entries.emplace_back(std::move(level.key), std::move(node));
    level.has_key = false;
  }

  std::string_view file_;
  std::vector<Level> levels_;
  std::size_t nodes_ = 0;
  bool stopped_ = false;
};

/// yaml-cpp says "end of map not found" where a tab is the reason: say so.
std::string explained(std::string_view text, const YAML::Mark& mark, const std::string& message) {
  std::size_t begin = 0;
  for (int line = 0; line < mark.line && begin != text.npos; ++line) {
    begin = text.find('\n', begin);
    if (begin != text.npos) ++begin;
  }
  if (begin == text.npos) return message;
  const auto line = text.substr(begin, text.find('\n', begin) - begin);
  const auto indentation = line.substr(0, line.find_first_not_of(" \t"));
  if (indentation.find('\t') == indentation.npos) return message;
  return "a tab stands in the indentation; YAML takes only blanks there";
}

Result<ConfigNode> parse(std::string_view text, std::string_view file) {
  TreeBuilder builder(file);
  ViewBuffer buffer(text);
  std::istream stream(&buffer);
  try {  // yaml-cpp reports by exceptions; they end here
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    TreeBuilder second(file);
    if (builder.errors.empty() && parser.HandleNextDocument(second)) {
      builder.errors.add({std::string(file), 0, 0}, "", "holds more than one document, expected one");
    }
  } catch (const YAML::Exception& error) {
    const auto& mark = error.mark;
    const auto at = mark.is_null() ? ConfigPlace{std::string(file), 0, 0}
                                   : ConfigPlace{std::string(file), mark.line + 1, mark.column + 1};
    builder.errors.add(at, "", explained(text, mark, error.msg));
  } catch (const std::exception& error) {
    builder.errors.add({std::string(file), 0, 0}, "", error.what());
  }
  if (!builder.errors.empty()) return fail(ErrorCode::kInvalid, builder.errors.text());
  return std::move(builder.root);
}

}  // namespace

Result<ConfigNode> parse_yaml(std::string_view text, std::string_view file_name) {
  if (text.size() > kMaxYamlBytes) {
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: {} bytes, a configuration has at most {}", file_name, text.size(), kMaxYamlBytes));
  }
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  auto tree = parse(text, file_name);
  if (!tree) return tree;
  if (tree->kind == ConfigNode::Kind::kMap) return tree;
  return fail(ErrorCode::kInvalid, fmt::format("{}:1:1: expected a map (island:, networks:, ...)", file_name));
}

Result<ConfigNode> parse_yaml_value(std::string_view text, std::string_view shown_as) {
  auto tree = parse(text, shown_as);
  if (!tree) return tree;
  const auto forget_places = [&shown_as](auto&& self, ConfigNode& node) -> void {
    node.place = {std::string(shown_as), 0, 0};
    for (auto& item : node.items) self(self, item);
    for (auto& entry : node.entries) self(self, entry.second);
  };
  forget_places(forget_places, *tree);
  return tree;
}

}  // namespace rubicon::runtime
