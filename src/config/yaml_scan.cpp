#include "config/yaml_scan.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::config {

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

}  // namespace rubicon::config
