#include "config/yaml_fault.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <vector>

#include "config/yaml_scan.h"

namespace rubicon::config {

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

/// "illegal map value": a key where none can be. The mark is its colon.
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

/// "end of map not found": a line that goes on with none of those above.
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
