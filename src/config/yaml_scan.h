#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "config/yaml_fault.h"

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

}  // namespace rubicon::config
