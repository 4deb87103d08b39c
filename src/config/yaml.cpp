#include "config/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <istream>
#include <optional>
#include <set>
#include <streambuf>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "base/log.h"
#include "base/text.h"
#include "rubicon/key.hpp"

namespace rubicon::config {

namespace {

constexpr std::size_t kMaxErrors = 100;

class ViewBuffer final : public std::streambuf {
 public:
  explicit ViewBuffer(std::string_view text) {
    auto* begin = const_cast<char*>(text.data());  // setg wants it mutable; an input buffer never writes
    setg(begin, begin, begin + text.size());
  }
};

/// Builds the tree from the parser's events. After an error it ignores them, so that nothing grows.
class TreeBuilder final : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string_view file) : file_(std::make_shared<const std::string>(file)) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { leaf(mark, ConfigNode::Kind::kNull, {}, false); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    stop(mark, "aliases (*name) are not supported; write the value out");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& value) override {
    last_line_ = mark.line + 1;
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

  /// In which the last value began.
  int last_line() const { return last_line_; }

  base::ConfigErrors errors;
  ConfigNode root;

 private:
  struct Level {
    ConfigNode node;
    std::string key;
    YAML::Mark key_mark;
    bool has_key = false;
    std::set<std::string> keys;
  };

  ConfigPlace place(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

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
    level.key_mark = mark;
    level.has_key = true;
    if (!level.keys.insert(text).second) {
      errors.add(place(mark), "", fmt::format("key {} is twice in this map", model::quoted(text)));
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
    node.items.shrink_to_fit();
    node.entries.shrink_to_fit();
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
    node.key_line = level.key_mark.line + 1;
    node.key_column = level.key_mark.column + 1;
    level.node.entries.emplace_back(std::move(level.key), std::move(node));
    level.has_key = false;
  }

  std::shared_ptr<const std::string> file_;
  std::vector<Level> levels_;
  std::size_t nodes_ = 0;
  int last_line_ = 0;
  bool stopped_ = false;
};

/// Line and column of a byte, both from 1.
YamlFault fault_at(std::string_view text, std::size_t byte, std::string what) {
  const auto before = text.substr(0, byte);
  const auto line_begin = before.rfind('\n') + 1;  // npos + 1 = 0
  return {static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1, static_cast<int>(byte - line_begin) + 1,
          std::move(what)};
}

/// Text that no YAML file holds: another encoding, or control characters.
std::optional<YamlFault> wrong_bytes(std::string_view text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    return YamlFault{1, 1, "the file is UTF-16, expected UTF-8"};
  if (const auto sound = base::utf8_prefix(text); sound != text.size()) {
    return fault_at(text, sound,
                    fmt::format("byte 0x{:02x} is not UTF-8; save the file as UTF-8 (Latin-1 and Windows-1252 write "
                                "umlauts so)",
                                static_cast<unsigned char>(text[sound])));
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7f)
      return fault_at(text, i, fmt::format("control character 0x{:02x}, expected text", c));
  }
  return {};
}

Error error_of(std::string_view file, const YamlFault& fault) {
  return {ErrorCode::kInvalid,
          fmt::format("{}: {}", to_string(ConfigPlace(file, fault.line, fault.column)), fault.text)};
}

Result<ConfigNode> parse(std::string_view text, std::string_view file) {
  if (const auto wrong = wrong_bytes(text)) return fail(error_of(file, *wrong));
  TreeBuilder builder(file);
  ViewBuffer buffer(text);
  std::istream stream(&buffer);
  try {  // yaml-cpp reports by exceptions; they end here
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    if (const auto open = unclosed_quote(text, builder.last_line())) return fail(error_of(file, *open));
    TreeBuilder second(file);
    if (builder.errors.empty() && parser.HandleNextDocument(second)) {
      builder.errors.add({file, 0, 0}, "", "holds more than one document, expected one");
    }
  } catch (const YAML::Exception& error) {
    const auto& mark = error.mark;
    if (mark.is_null()) {
      builder.errors.add({file, 0, 0}, "", error.msg);
    } else {
      const auto fault = explain_yaml_fault(text, {mark.line + 1, mark.column + 1, error.msg});
      builder.errors.add({file, fault.line, fault.column}, "", fault.text);
    }
  } catch (const std::exception& error) {
    builder.errors.add({file, 0, 0}, "", error.what());
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
  const ConfigPlace there(shown_as, 0, 0);
  const auto forget_places = [&there](auto&& self, ConfigNode& node) -> void {
    node.place = there;
    node.key_line = node.key_column = 0;
    for (auto& item : node.items) self(self, item);
    for (auto& entry : node.entries) self(self, entry.second);
  };
  forget_places(forget_places, *tree);
  return tree;
}

namespace {

using Kind = ConfigNode::Kind;

/// A map or list of at most this many characters is written on one line.
constexpr std::size_t kOneLine = 100;

bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string_view("-_./+*@").find(c) != std::string_view::npos;
}

/// Whether YAML reads it as the same text in every place without quotes.
bool may_stand_bare(std::string_view text) {
  if (text.empty() || text.front() == '*' || text.front() == '@' || text.front() == ':') return false;
  if (text.front() == '-' && (text.size() == 1 || std::isdigit(static_cast<unsigned char>(text[1])) == 0)) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool within = text[i] == ':' && i + 1 < text.size() && is_plain(text[i + 1]);
    if (!within && !is_plain(text[i])) return false;
  }
  return true;
}

/// Bare, or in double quotes.
std::string scalar_text(std::string_view text, bool quoted) {
  if (!quoted && may_stand_bare(text)) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

class Writer {
 public:
  explicit Writer(std::size_t most) : most_(most) {}

  /// Each entry of the map on lines of its own, so that a configuration does not become one line.
  std::string write(const ConfigNode& root) {
    entries(root, 0);
    return std::move(out_);
  }

 private:
  /// The text of a node in flow style; nullopt for a map or list that is longer than a line.
  std::optional<std::string> one_line(const ConfigNode& node, bool secret) const {
    if (node.kind == Kind::kNull) return std::string("null");
    if (node.kind == Kind::kScalar) {
      if (secret) return scalar_text(base::kMasked, true);
      return scalar_text(base::masked(node.text), node.was_quoted);
    }
    const bool map = node.kind == Kind::kMap;
    std::string out(1, map ? '{' : '[');
    const auto add = [&](std::string_view before, const ConfigNode& child, bool masked) {
      const auto text = out.size() < kOneLine ? one_line(child, masked) : std::nullopt;
      if (text) out += fmt::format("{}{}{}", out.size() > 1 ? ", " : "", before, *text);
      return text.has_value();
    };
    for (const auto& [key, child] : node.entries) {
      if (!add(scalar_text(key, false) + ": ", child, secret_of(key, child, secret))) return std::nullopt;
    }
    for (const auto& child : node.items) {
      if (!add("", child, secret)) return std::nullopt;
    }
    out += map ? '}' : ']';
    return out.size() <= kOneLine ? std::optional(std::move(out)) : std::nullopt;
  }

  /// A map below the name of a secret (`tokens: {file: ...}`) is judged by its own names.
  static bool secret_of(std::string_view key, const ConfigNode& child, bool parent) {
    return child.kind != Kind::kMap && (base::names_secret(key) || parent);
  }

  void entries(const ConfigNode& map, std::size_t depth) {
    for (const auto& [key, child] : map.entries)
      element(scalar_text(key, false) + ":", child, depth, secret_of(key, child, false));
  }

  /// `head` is `key:` or `-`.
  void element(std::string_view head, const ConfigNode& node, std::size_t depth, bool secret) {
    const std::string indent(2 * depth, ' ');
    if (const auto text = one_line(node, secret)) return line(fmt::format("{}{} {}", indent, head, *text));
    line(fmt::format("{}{}", indent, head));
    if (node.kind == Kind::kMap) return entries(node, depth + 1);
    for (const auto& item : node.items) element("-", item, depth + 1, secret);
  }

  void line(std::string_view text) {
    constexpr std::string_view kCut = "# the rest is too long to be shown\n";
    if (full_) return;
    full_ = out_.size() + text.size() + 1 + kCut.size() > most_;
    if (full_) return void(out_ += kCut);
    out_ += text;
    out_ += '\n';
  }

  std::size_t most_;
  bool full_ = false;
  std::string out_;
};

}  // namespace

std::string yaml_text(const ConfigNode& root, std::size_t most) {
  return Writer(most).write(root);
}

}  // namespace rubicon::config
