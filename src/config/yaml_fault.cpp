#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "config/yaml.h"

namespace rubicon::config {

/// Reads YAML only as far as quotes, brackets, comments and block texts go, and stops at the first one that does not
/// fit. Not a parser: what it finds is a fault only in a text that a parser refused, but for an unclosed quote.
class YamlScan {
 public:
  explicit YamlScan(std::string_view text) : text_(text) {}

  /// The first fault of brackets and quotes.
  std::optional<YamlFault> run();
  /// It was a quote that never closes.
  bool quote_is_open() const { return quote_is_open_; }

 private:
  struct Place {
    int line = 1, column = 1;
  };
  struct Opened {
    char bracket;
    Place at;
  };

  bool at_end() const { return pos_ >= text_.size(); }
  char peek(std::size_t ahead = 0) const { return pos_ + ahead < text_.size() ? text_[pos_ + ahead] : '\0'; }
  void advance();
  bool blank_at(std::size_t ahead) const;
  bool in_flow() const { return !opened_.empty(); }

  void token();
  bool marker() const;
  void comment();
  void quoted(char quote);
  void behind_quote(Place from, char quote);
  void close(char bracket);
  void property();
  void block_text();
  void plain();
  bool goes_on() const;
  void fault(Place at, std::string text);

  std::string_view text_;
  std::size_t pos_ = 0;
  Place at_;
  int parent_ = 0;  ///< column of the last key or list item outside brackets, whose value comes; 0 = none
  std::vector<Opened> opened_;
  std::optional<YamlFault> fault_;
  bool quote_is_open_ = false;
};

std::optional<YamlFault> YamlScan::run() {
  while (!at_end() && !fault_) token();
  if (!fault_ && !opened_.empty()) {
    const auto& last = opened_.back();
    fault(last.at, fmt::format("the '{}' that opens here is never closed", last.bracket));
  }
  return fault_;
}

void YamlScan::advance() {
  if (text_[pos_++] == '\n') {
    ++at_.line;
    at_.column = 1;
  } else {
    ++at_.column;
  }
}

/// Blank, end of the line or of the text.
bool YamlScan::blank_at(std::size_t ahead) const {
  const char c = peek(ahead);
  return pos_ + ahead >= text_.size() || c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

void YamlScan::fault(Place at, std::string text) {
  fault_ = YamlFault{at.line, at.column, std::move(text)};
}

/// `---` or `...`: begins or ends the text, or a line for the parser (`%`).
bool YamlScan::marker() const {
  const auto rest = text_.substr(pos_);
  return at_.column == 1 &&
         (rest.starts_with('%') || ((rest.starts_with("---") || rest.starts_with("...")) && blank_at(3)));
}

void YamlScan::token() {
  const char c = peek();
  if (blank_at(0)) return advance();
  if (c == '#' || (c == '%' && marker())) return comment();
  if (marker()) {
    parent_ = 0;
    for (int i = 0; i < 3; ++i) advance();
    return;
  }
  if (c == '"' || c == '\'') return quoted(c);
  if (c == '[' || c == '{') {
    opened_.push_back({c, at_});
    return advance();
  }
  if (c == ']' || c == '}') return close(c);
  if ((c == '|' || c == '>') && !in_flow()) return block_text();
  if (c == '&' || c == '!') return property();
  if ((c == '-' || c == '?') && blank_at(1) && !in_flow()) parent_ = at_.column;
  if (c == ',' || ((c == '-' || c == '?' || c == ':') && (blank_at(1) || in_flow()))) return advance();
  plain();
}

void YamlScan::comment() {
  while (!at_end() && peek() != '\n') advance();
}

void YamlScan::quoted(char quote) {
  const Place from = at_;
  advance();
  while (!at_end()) {
    if (quote == '"' && peek() == '\\' && pos_ + 1 < text_.size()) {
      advance();
    } else if (quote == '\'' && peek() == '\'' && peek(1) == '\'') {
      advance();
    } else if (peek() == quote) {
      advance();
      return behind_quote(from, quote);
    }
    advance();
  }
  quote_is_open_ = true;
  fault(from, fmt::format("the {} that opens here is never closed", quote));
}

/// Only what ends a value may follow; else the quote closed too early, or was meant to close lines above.
void YamlScan::behind_quote(Place from, char quote) {
  const Place behind = at_;
  while (peek() == ' ' || peek() == '\t') advance();
  const char c = peek();
  if (c == ':' && !in_flow()) parent_ = from.column;
  if (blank_at(0) || c == '#' || c == ':' || c == ',' || c == ']' || c == '}') return;
  if (from.line != behind.line)
    return fault(from, fmt::format("the {} that opens here closes only in line {}", quote, behind.line));
  fault(at_, fmt::format("text follows the closing {0}; within the quotes write {1} for {0}", quote,
                         quote == '"' ? "\\\"" : "''"));
}

void YamlScan::close(char bracket) {
  const char wanted = bracket == ']' ? '[' : '{';
  if (opened_.empty()) return fault(at_, fmt::format("this '{}' closes nothing", bracket));
  const auto last = opened_.back();
  if (last.bracket != wanted) {
    return fault(last.at, fmt::format("the '{}' that opens here meets '{}' in line {}, column {}, expected '{}'",
                                      last.bracket, bracket, at_.line, at_.column, last.bracket == '[' ? ']' : '}'));
  }
  opened_.pop_back();
  advance();
}

/// An anchor or a tag; the value follows it.
void YamlScan::property() {
  while (!blank_at(0) && !(in_flow() && std::string_view(",[]{}").find(peek()) != std::string_view::npos)) advance();
}

/// `|` or `>`: all lines that follow and are deeper than what they are the value of, are text.
void YamlScan::block_text() {
  comment();
  while (!at_end()) {
    const auto begin = text_.find_first_not_of(' ', pos_ + 1);
    const bool empty = begin == text_.npos || text_[begin] == '\n' || text_[begin] == '\r';
    if (!empty && static_cast<int>(begin - (pos_ + 1)) < parent_) return;
    advance();
    comment();
  }
}

/// Whether the next line that is not empty goes on with a text without quotes.
bool YamlScan::goes_on() const {
  const auto next = text_.find_first_not_of(" \t\r\n", pos_);
  if (next == text_.npos || text_[next] == '#') return false;
  const auto column = next - text_.rfind('\n', next);
  return in_flow() || (parent_ > 0 && static_cast<int>(column) > parent_);
}

/// Up to what ends it: the last of its lines, a comment, a colon, in brackets a comma or bracket.
void YamlScan::plain() {
  int begin = at_.column;
  while (!at_end()) {
    const char c = peek();
    if (c == '\n') {
      if (!goes_on()) return;
      while (blank_at(0)) advance();
      begin = at_.column;
      continue;
    }
    if (in_flow() && (c == ',' || c == '[' || c == ']' || c == '{' || c == '}')) return;
    if (c == ':' && blank_at(1)) {
      if (!in_flow()) parent_ = begin;
      return advance();
    }
    if ((c == ' ' || c == '\t') && peek(1) == '#') return advance();
    advance();
  }
}

namespace {

/// Lines above that are looked at for their indentation.
constexpr std::size_t kLinesAbove = 1000;
constexpr std::size_t kShownText = 40;

/// One line: its indentation, and what it says without comment.
struct Line {
  int number = 0;
  std::size_t indentation = 0;
  std::string_view says;
};

std::string_view without_comment(std::string_view text) {
  if (text.starts_with('#')) return {};
  const auto comment = text.find(" #");
  text = text.substr(0, comment);
  return text.substr(0, text.find_last_not_of(" \t\r") + 1);
}

/// The lines that say something, up to this number, the last first.
std::vector<Line> lines_up_to(std::string_view text, int number) {
  std::vector<Line> lines;
  for (int i = 1; i <= number && !text.empty(); ++i) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto begin = std::min(line.find_first_not_of(' '), line.size());
    const auto says = without_comment(line.substr(begin));
    if (!says.empty()) lines.push_back({i, begin, says});
  }
  std::reverse(lines.begin(), lines.end());
  return lines;
}

/// The byte where `text` has a colon that ends a key; npos = none.
std::size_t key_colon(std::string_view text) {
  for (std::size_t at = text.find(':'); at != text.npos; at = text.find(':', at + 1)) {
    if (at + 1 == text.size() || text[at + 1] == ' ' || text[at + 1] == '\t') return at;
  }
  return text.npos;
}

YamlFault at(const Line& line, std::size_t offset, std::string text) {
  return {line.number, static_cast<int>(line.indentation + offset) + 1, std::move(text)};
}

std::optional<YamlFault> tab_in_indentation(std::string_view text, int last) {
  for (int number = 1; number <= last && !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto begin = line.find_first_not_of(" \t\r");
    const auto tab = line.find('\t');
    if (begin == line.npos || line[begin] == '#' || tab > begin) continue;
    return YamlFault{number, static_cast<int>(tab) + 1, "the indentation has a tab; YAML accepts only blanks there"};
  }
  return {};
}

/// "illegal map value": a key where no key can stand. yaml-cpp marks its colon.
YamlFault about_a_key(const YamlFault& parsers, const std::vector<Line>& lines) {
  if (lines.empty() || lines[0].number != parsers.line) return {parsers.line, parsers.column, "no key can stand here"};
  const auto& line = lines[0];
  const auto colon = key_colon(line.says);
  if (colon != line.says.npos && line.indentation + colon + 1 < static_cast<std::size_t>(parsers.column)) {
    return {parsers.line, parsers.column, "a second ':' in one value; put a text that contains ': ' in quotes"};
  }
  if (lines.size() > 1) {
    const auto& above = lines[1];
    const auto tight = above.says.find(':');
    const auto shown = above.says.substr(0, kShownText);
    if (key_colon(above.says) == above.says.npos && !above.says.starts_with("- ")) {
      if (tight != above.says.npos) return at(above, tight, "a blank must follow the ':' of a key");
      return at(above, above.says.size(), fmt::format("a ':' is missing behind '{}'", shown));
    }
    if (line.indentation > above.indentation) {
      return at(line, 0, fmt::format("this line is deeper than the one above it, '{}', which has its value", shown));
    }
  }
  return {parsers.line, parsers.column, "no key can stand here"};
}

/// "end of map not found": a line whose indentation matches none of the lines above.
YamlFault about_a_line(const YamlFault& parsers, const std::vector<Line>& lines) {
  if (lines.empty() || lines[0].number != parsers.line) {
    return {parsers.line, parsers.column, "this does not belong to the map or list above"};
  }
  const auto& line = lines[0];
  std::set<std::size_t> levels;
  std::size_t lowest = std::string_view::npos;
  for (std::size_t i = 1; i < lines.size() && i < kLinesAbove; ++i) {
    if (lines[i].indentation >= lowest) continue;
    lowest = lines[i].indentation;
    levels.insert(lowest);
  }
  if (!levels.empty() && !levels.contains(line.indentation)) {
    return at(line, 0,
              fmt::format("this line begins with {} blanks, expected {} as the lines above", line.indentation,
                          fmt::join(levels, " or ")));
  }
  if (line.says.starts_with('-')) return at(line, 0, "a list item ('- ') cannot stand among the keys of a map");
  if (key_colon(line.says) == line.says.npos) return at(line, 0, "expected a key and its value: `key: value`");
  return {parsers.line, parsers.column, "a value cannot begin or go on here; put it in quotes"};
}

/// The parser's other words, and ours.
struct Words {
  std::string_view parsers, ours;
};
constexpr Words kWords[] = {
    {"unknown token", "a value cannot begin with this character; put it in quotes"},
    {"the referenced anchor is not defined",
     "aliases (*name) are not supported; write the value out, or put a text that begins with * in quotes"},
    {"illegal block entry", "a list item ('- ') cannot stand here; begin the list on a line of its own"},
    {"illegal map key", "no key can stand here"},
    {"illegal flow end", "this bracket closes nothing"},
    {"end of map flow not found", "expected ',' or '}' here; put a text that contains ': ' or ', ' in quotes"},
    {"end of sequence flow not found", "expected ',' or ']' here; put a text that contains ': ' or ', ' in quotes"},
    {"unknown escape character", "no escape begins so; write \\\\ for a backslash, or use single quotes"},
    {"bad character found while scanning hex number", "expected hex digits behind \\x, \\u or \\U"},
    {"invalid unicode", "there is no character of this number"},
    {"unexpected character in block scalar",
     "only a line end can stand behind | and >; put a text that begins with them in quotes"},
    {"cannot set zero indentation for a block scalar", "expected a number from 1 to 9 behind | and >"},
    {"end of verbatim tag not found", "'!' begins a tag; put a text that begins with it in quotes"},
    {"illegal character found while scanning tag handle", "'!' begins a tag; put a text that begins with it in quotes"},
    {"tag handle with no suffix", "'!' begins a tag; put a text that begins with it in quotes"},
    {"cannot assign multiple tags to the same node", "two tags (!) stand before one value"},
    {"cannot assign multiple anchors to the same node", "two anchors (&) stand before one value"},
    {"cannot assign multiple aliases to the same node", "aliases (*name) are not supported; write the value out"},
    {"aliases can't have any content, *including* tags", "aliases (*name) are not supported; write the value out"},
    {"alias not found after *", "'*' begins an alias; put a text that begins with it in quotes"},
    {"illegal character found while scanning alias", "'*' begins an alias; put a text that begins with it in quotes"},
    {"anchor not found after &", "'&' begins an anchor; put a text that begins with it in quotes"},
    {"illegal character found while scanning anchor", "'&' begins an anchor; put a text that begins with it in quotes"},
    {"illegal document indicator in scalar", "--- and ... at the beginning of a line end the text: the quote is open"},
    {"illegal EOF in scalar", "the file ends within a quoted text"},
    {"illegal tab when looking for indentation", "the indentation has a tab; YAML accepts only blanks there"},
    {"bad YAML version", "expected %YAML 1.2 or no such line"},
    {"YAML major version too large", "expected %YAML 1.2 or no such line"},
};

}  // namespace

std::optional<YamlFault> unclosed_quote(std::string_view text, int last_line) {
  YamlScan scan(text);
  auto found = scan.run();
  return scan.quote_is_open() && found->line == last_line ? found : std::nullopt;
}

YamlFault explain_yaml_fault(std::string_view text, const YamlFault& parsers) {
  if (auto tab = tab_in_indentation(text, parsers.line)) return *std::move(tab);
  // What comes after the parser's place cannot have stopped it.
  if (auto found = YamlScan(text).run(); found && found->line <= parsers.line) return *std::move(found);
  if (parsers.text == "illegal map value") return about_a_key(parsers, lines_up_to(text, parsers.line));
  if (parsers.text == "end of map not found" || parsers.text == "end of sequence not found")
    return about_a_line(parsers, lines_up_to(text, parsers.line));
  for (const auto& words : kWords) {
    if (parsers.text.starts_with(words.parsers)) return {parsers.line, parsers.column, std::string(words.ours)};
  }
  return {parsers.line, parsers.column, fmt::format("this is no YAML ({})", parsers.text)};
}

}  // namespace rubicon::config
