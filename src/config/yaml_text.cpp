#include "config/yaml_text.h"

#include <fmt/format.h>

#include <cctype>
#include <optional>
#include <string_view>

#include "base/masked.h"

namespace rubicon::config {

namespace {

using Kind = ConfigNode::Kind;

/// A map or list that fits into so many characters stands on one line.
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
