#include "runtime/yaml_scan.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::runtime {

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
    line_begin_ = pos_;
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

void YamlScan::token() {
  const char c = peek();
  if (blank_at(0)) return advance();
  if (c == '#') return comment();
  if (c == '"' || c == '\'') return quoted(c);
  if (c == '[' || c == '{') {
    opened_.push_back({c, at_});
    return advance();
  }
  if (c == ']' || c == '}') return close(c);
  if ((c == '|' || c == '>') && !in_flow()) return block_text();
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
  if (blank_at(0) || c == '#' || c == ':' || c == ',' || c == ']' || c == '}') return;
  if (from.line != behind.line)
    return fault(from, fmt::format("the {} that opens here closes only in line {}", quote, behind.line));
  fault(at_, fmt::format("text stands behind the closing {0}; within the quotes write {1} for {0}", quote,
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

/// `|` or `>`: all deeper lines that follow are text.
void YamlScan::block_text() {
  const auto indentation = text_.find_first_not_of(' ', line_begin_) - line_begin_;
  comment();
  while (!at_end()) {
    const auto begin = text_.find_first_not_of(' ', pos_ + 1);
    const bool empty = begin == text_.npos || text_[begin] == '\n' || text_[begin] == '\r';
    if (!empty && begin - (pos_ + 1) <= indentation) return;
    advance();
    comment();
  }
}

/// Up to what ends it: the line, a comment, a colon, in brackets a comma or bracket.
void YamlScan::plain() {
  while (!at_end() && peek() != '\n') {
    const char c = peek();
    if (in_flow() && (c == ',' || c == '[' || c == ']' || c == '{' || c == '}')) return;
    if (c == ':' && blank_at(1)) return advance();
    if ((c == ' ' || c == '\t') && peek(1) == '#') return advance();
    advance();
  }
}

}  // namespace rubicon::runtime
