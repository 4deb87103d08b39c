#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace rubicon::verbs {

/// Parses JSON from outside: kInvalid for what is not an object, or nests deeper than a request can.
Result<nlohmann::json> parse_object(std::string_view text);

/// The members of a request from outside: a JSON object, the query of a URL, or the words of a line. Numbers, times and
/// flags may be given as text, too, as they always are in a query. Keeps the first fault: which member, its value, and
/// what was expected. The getters return the default after a fault.
class Members {
 public:
  explicit Members(nlohmann::json object) : tree_(std::move(object)) {}
  /// Of a query. A name that is given several times is a list.
  explicit Members(const std::vector<std::pair<std::string, std::string>>& texts);

  /// What came another way, such as the body of the request. A fault if there is such a member.
  void add(std::string_view name, nlohmann::json value);

  bool has(const char* name) { return find(name) != nullptr; }
  /// The text of a member, without a check; empty if there is none, or it is no text.
  std::string peek(const char* name) const;
  /// Puts the key of a tuple in the place of what people call it.
  void resolve(const char* name, std::string key);
  /// Whether that was done.
  bool is_resolved() const { return is_resolved_; }
  /// A text that has to be there.
  std::string text(const char* name, std::string_view expected);
  std::string text_or(const char* name, std::string otherwise);
  /// One text or a list of at most `most`, none of them empty; none if there is no such member.
  std::vector<std::string> texts(const char* name, std::string_view expected, std::size_t most);
  /// From `least` to `most`.
  double number_or(const char* name, double otherwise, double least, double most);
  std::optional<std::uint64_t> count(const char* name, std::uint64_t least, std::uint64_t most);
  /// A number of `unit`, or a text with its own unit: `250ms`.
  Duration span_or(const char* name, Duration otherwise, Duration unit, Duration longest);
  /// Seconds since 1970, 0 = none, or a text that says how long from `now`: `5min`, `-1h`.
  WallTime time_or(const char* name, WallTime otherwise, WallTime now);
  /// False if there is none. An empty text is true: `?raw`.
  bool flag(const char* name);
  /// `6541:proxy.island`, without wildcards; has to be there.
  Pattern tuple(const char* name);
  Pattern pattern(const char* name);
  /// The member `value` as text, or the bytes of `b64`; one of them has to be there.
  std::string value();

  /// The first fault, or a member that no getter has asked for.
  Result<void> end() const;
  void fault(std::string text, ErrorCode code = ErrorCode::kInvalid);

 private:
  const nlohmann::json* find(const char* name);
  std::optional<std::string> shown(const char* name);
  void wrong(const char* name, std::string_view got, std::string_view expected);
  void missing(const char* name, std::string_view expected);

  nlohmann::json tree_;
  std::vector<std::string> known_;
  std::optional<Error> fault_;
  bool is_resolved_ = false;
};

}  // namespace rubicon::verbs
