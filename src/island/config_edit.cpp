#include "island/config_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <utility>
#include <vector>

#include "base/config_reader.h"
#include "base/text.h"
#include "config/yaml.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

using Kind = ConfigNode::Kind;

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr std::size_t kIndent = 2;

/// The lines of a text, without the characters that end them.
std::vector<std::string_view> lines_in(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    auto line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t\r") == line.npos;
}

/// The options as lines of their own, without what all are indented by.
std::vector<std::string_view> option_lines(std::string_view options) {
  auto lines = lines_in(options);
  while (!lines.empty() && is_blank(lines.back())) lines.pop_back();
  auto common = std::numeric_limits<std::size_t>::max();
  for (const auto line : lines) {
    if (!is_blank(line)) common = std::min(common, line.find_first_not_of(' '));
  }
  for (auto& line : lines) line = is_blank(line) ? std::string_view() : line.substr(common);
  return lines;
}

bool is_in_braces(std::string_view options) {
  return base::trimmed(options).starts_with('{');
}

/// The network on lines of its own.
std::string block_of(const std::string& network, std::string_view options, std::size_t indent) {
  const std::string margin(indent, ' ');
  auto out = fmt::format("{}{}:", margin, network);
  bool inline_next = is_in_braces(options);
  for (const auto line : option_lines(options)) {
    if (std::exchange(inline_next, false))
      out += fmt::format(" {}", line);
    else
      out += line.empty() ? "\n" : fmt::format("\n{}  {}", margin, line);
  }
  return out + "\n";
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      base::append(out, "\\x{:02x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + '"';
}

/// A tree in braces and brackets.
std::string flow_of(const ConfigNode& node) {
  if (node.kind == Kind::kNull) return node.text;
  if (node.kind == Kind::kScalar) return node.was_quoted ? in_quotes(node.text) : scalar_text(node.text);
  std::string out;
  for (const auto& [key, child] : node.entries)
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", scalar_text(key), flow_of(child));
  for (const auto& child : node.items) out += fmt::format("{}{}", out.empty() ? "" : ", ", flow_of(child));
  return node.kind == Kind::kMap ? "{" + out + "}" : "[" + out + "]";
}

/// A text of a configuration and the places of its tree.
class FileText {
 public:
  static Result<FileText> read(std::string_view text, const std::string& file) {
    FileText source;
    if (text.starts_with(kByteOrderMark)) source.begin_ = kByteOrderMark.size();
    auto root = config::parse_yaml(text, file);
    if (!root) return fail(root.error());
    source.text_ = text;
    source.root = std::move(*root);
    source.starts_ = {source.begin_};
    for (auto at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1)) source.starts_.push_back(at + 1);
    return source;
  }

  ConfigNode root;

  /// Of a place; the end of the text for what is behind it.
  std::size_t offset(int line, int column) const {
    if (line < 1 || static_cast<std::size_t>(line) > starts_.size()) return text_.size();
    return std::min(starts_[static_cast<std::size_t>(line) - 1] + static_cast<std::size_t>(column) - 1, text_.size());
  }
  std::size_t offset(const ConfigNode& node) const { return offset(node.place.line, node.place.column); }
  bool is_in_braces(const ConfigNode& node) const { return offset(node) < text_.size() && text_[offset(node)] == '{'; }
  std::string_view from(std::size_t at) const { return text_.substr(at); }
  std::size_t size() const { return text_.size(); }

  /// Where what belongs to an entry of the top map ends: before the next one, and before the blank lines and comments
  /// above that.
  std::size_t end_of(const ConfigNode& entry) const {
    int next = static_cast<int>(starts_.size()) + 1;
    for (const auto& [key, other] : root.entries) {
      if (other.key_line > entry.key_line) next = std::min(next, other.key_line);
    }
    while (next - 1 > entry.key_line && is_beside(next - 1, entry.key_column)) --next;
    return offset(next, 1);
  }

  /// The text with `more` at the place. Lines of `more` end as those of the text do.
  std::string inserted(std::size_t at, std::string_view more, std::size_t replaced = 0) const {
    std::string out(text_.substr(0, at));
    const bool starts_line = at == 0 || text_[at - 1] == '\n';
    const auto newline = newline_of();
    if (more.ends_with('\n') && !starts_line) out += newline;
    for (const char c : more) c == '\n' ? out += newline : out += c;
    return out += text_.substr(at + replaced);
  }

 private:
  std::string_view newline_of() const { return text_.find("\r\n") == text_.npos ? "\n" : "\r\n"; }

  /// A blank line, or a comment no deeper than the key.
  bool is_beside(int line, int key_column) const {
    const auto begin = offset(line, 1);
    const auto whole = text_.substr(begin, offset(line + 1, 1) - begin);
    const auto first = whole.find_first_not_of(" \t\r\n");
    return first == whole.npos || (whole[first] == '#' && first < static_cast<std::size_t>(key_column));
  }

  std::string_view text_;
  std::size_t begin_ = 0;
  std::vector<std::size_t> starts_;  ///< of lines
};

Error cannot(const std::string& file, const ConfigNode& node, std::string_view why) {
  const auto place = node.place.line > 0 ? to_string(node.key_place()) : file;
  return {ErrorCode::kUnsupported, fmt::format("{}: {}: insert it yourself", place, why)};
}

/// The changed text, if it says what is expected and nothing else.
Result<std::string> verified(std::string changed, const ConfigNode& expected, const std::string& file) {
  const auto now = config::parse_yaml(changed, file);
  if (now && base::differences(expected, *now, 1).empty()) return changed;
  return fail(cannot(file, ConfigNode(), "the file is written in a way in which nothing can be inserted safely"));
}

Result<void> check_name(const std::string& network) {
  if (!network.empty() && model::to_key_part(network) == network) return {};
  return fail(ErrorCode::kInvalid, fmt::format("the network is called {}, expected 1 to 64 letters, digits, - and _",
                                               model::quoted(network)));
}

/// Where and what: into braces, or on lines of its own.
std::string text_with(const FileText& source, const ConfigNode* networks, const std::string& network,
                      std::string_view options, const ConfigNode& tree) {
  if (networks == nullptr) return source.inserted(source.size(), "networks:\n" + block_of(network, options, kIndent));
  const auto at = source.offset(*networks);
  if (networks->kind == Kind::kMap && source.is_in_braces(*networks)) {
    const bool is_alone = networks->entries.empty();
    return source.inserted(at + 1, fmt::format("{}: {}{}", network, flow_of(tree), is_alone ? "" : ", "));
  }
  const auto column = networks->kind == Kind::kMap ? networks->entries.front().second.key_column - 1
                                                   : networks->key_column - 1 + static_cast<int>(kIndent);
  return source.inserted(source.end_of(*networks), block_of(network, options, static_cast<std::size_t>(column)));
}

}  // namespace

std::string scalar_text(std::string_view text) {
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_./+-").find(c) != std::string_view::npos;
  };
  const bool is_sign =
      text.starts_with('-') && (text.size() < 2 || std::isdigit(static_cast<unsigned char>(text[1])) == 0);
  const bool is_bare = !text.empty() && text != "null" && !is_sign && std::all_of(text.begin(), text.end(), is_plain);
  return is_bare ? std::string(text) : in_quotes(text);
}

std::string network_text(const std::string& network, std::string_view options) {
  return "networks:\n" + block_of(network, options, kIndent);
}

Result<std::string> with_network(std::string_view text, const std::string& file, const std::string& network,
                                 std::string_view options) {
  if (auto good = check_name(network); !good) return fail(good.error());
  const auto source = FileText::read(text, file);
  if (!source) return fail(source.error());
  auto tree = config::parse_yaml(options, "options");
  if (!tree) return fail(tree.error());
  const auto* networks = source->root.find("networks");
  if (networks != nullptr && networks->kind == Kind::kList)
    return fail(cannot(file, *networks,
                       "networks is a list, expected a map with a name for each, such as `dummy-1: {type: dummy}`"));
  if (networks != nullptr && networks->kind == Kind::kScalar)
    return fail(cannot(file, *networks,
                       "networks is no map, expected one with a name for each, such as `dummy-1: {type: dummy}`"));
  if (const auto* there = networks != nullptr ? networks->find(network) : nullptr)
    return fail(ErrorCode::kDuplicate, fmt::format("{}: there is a network {} already, expected another name",
                                                   to_string(there->key_place()), network));
  auto changed = text_with(*source, networks, network, options, *tree);
  auto expected = source->root;
  auto* map = expected.find("networks");
  if (map == nullptr) map = &expected.entries.emplace_back("networks", ConfigNode()).second;
  map->kind = Kind::kMap;
  map->text.clear();
  map->entries.emplace_back(network, std::move(*tree));
  return verified(std::move(changed), expected, file);
}

namespace {

/// How many bytes a scalar takes in the file; 0: it is not written in one piece.
std::size_t length_of(const FileText& source, const ConfigNode& scalar) {
  const auto rest = source.from(source.offset(scalar));
  if (rest.starts_with(scalar.text)) return scalar.text.size();
  if (rest.empty() || (rest.front() != '"' && rest.front() != '\'')) return 0;
  const auto end = rest.find(rest.front(), 1);
  return end == rest.npos ? 0 : end + 1;
}

}  // namespace

Result<std::string> with_option(std::string_view text, const std::string& file, const std::string& network,
                                const std::string& option, const std::string& value) {
  const auto source = FileText::read(text, file);
  if (!source) return fail(source.error());
  const auto* networks = source->root.find("networks");
  const auto* map = networks != nullptr ? networks->find(network) : nullptr;
  if (map == nullptr) return fail(ErrorCode::kNotFound, fmt::format("{}: there is no network {}", file, network));
  if (map->kind != Kind::kMap || map->entries.empty()) return fail(cannot(file, *map, "the network has no options"));
  std::string changed;
  const auto entry = fmt::format("{}: {}", option, scalar_text(value));
  if (const auto* there = map->find(option)) {
    const auto length = there->kind == Kind::kScalar ? length_of(*source, *there) : 0;
    if (length == 0) return fail(cannot(file, *there, fmt::format("{} is not a text on one line", option)));
    changed = source->inserted(source->offset(*there), scalar_text(value), length);
  } else if (source->is_in_braces(*map)) {
    changed = source->inserted(source->offset(*map) + 1, entry + ", ");
  } else {
    const std::string margin(static_cast<std::size_t>(map->entries.front().second.key_column) - 1, ' ');
    changed = source->inserted(source->offset(map->key_line + 1, 1), margin + entry + "\n");
  }
  auto expected = source->root;
  auto& options = *expected.find("networks")->find(network);
  auto* node = options.find(option);
  if (node == nullptr) node = &options.entries.emplace_back(option, ConfigNode()).second;
  *node = ConfigNode();
  node->kind = Kind::kScalar;
  node->text = value;
  node->was_quoted = scalar_text(value).starts_with('"');
  return verified(std::move(changed), expected, file);
}

}  // namespace rubicon::island
