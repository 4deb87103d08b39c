#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"
#include "rubicon/tuple.hpp"

namespace rubicon::web::api {

/// Parses JSON from outside: kInvalid for what is no object, or nests deeper than a request can.
Result<nlohmann::json> parse_object(std::string_view text);

/// The members of a JSON object that a client sent. Keeps the first fault: which member of what, its value, and what
/// was expected. The getters return the default after a fault.
class Members {
 public:
  /// `what` begins the error texts: `subscribe`. The tree must outlive this.
  Members(const nlohmann::json& tree, std::string what) : tree_(tree), what_(std::move(what)) {}

  /// What begins the error texts from now on.
  void name(std::string what) { what_ = std::move(what); }

  bool has(const char* name) const { return tree_.contains(name); }
  /// A text that has to be there.
  std::string text(const char* name, std::string_view expected);
  std::string text_or(const char* name, std::string default_text);
  /// One text or a list of at most `most`, none of them empty; none if there is no such member.
  std::vector<std::string> texts(const char* name, std::string_view expected, std::size_t most);
  /// From `least` to `most`.
  double number_or(const char* name, double otherwise, double least, double most);
  std::optional<std::uint64_t> count(const char* name, std::uint64_t most);
  bool flag_or(const char* name, bool otherwise);
  /// `6541:proxy.island`, without wildcards.
  Pattern tuple(const char* name);
  Pattern pattern(const char* name);
  /// The member `value` as text, or the bytes of `b64`; one of them has to be there.
  std::string value();

  /// The first fault, or a member that no getter has asked for.
  Result<void> end();
  void fault(Error error);

 private:
  const nlohmann::json* find(const char* name);
  void wrong(const char* name, const nlohmann::json& got, std::string_view expected);
  void missing(const char* name, std::string_view expected);

  const nlohmann::json& tree_;
  std::string what_;
  std::vector<std::string> known_;
  std::optional<Error> fault_;
};

}  // namespace rubicon::web::api
