#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "rubicon/address.hpp"
#include "rubicon/result.hpp"

namespace rubicon::tuples::mqtt {

/// A connection of a user to the broker. Each connection has a new token, so that the will of an old one cannot remove
/// what a new one shows.
struct Line {
  std::string user;   ///< as the broker knows it; `-` = without a name
  std::string token;  ///< 12 hexadecimal digits
  friend auto operator<=>(const Line&, const Line&) = default;
};

inline constexpr std::string_view kAnonymous = "-";
inline constexpr std::size_t kMaxUser = 64;  ///< bytes

/// Whether a user can have a place in topics: kInvalid says why not. With `/` in a name the patterns of a broker's
/// rights would let it write in the name of another user.
Result<void> check_user(std::string_view user);
/// 1 to 64 of `[0-9A-Za-z_.-]`.
bool is_space(std::string_view name);

/// The topics of one space, below `rubicon-space/1/<space>/` (docs/sites.md). Everything that is parsed has exactly the
/// levels that it should have.
class Topics {
 public:
  explicit Topics(std::string_view space);

  /// Retained: the connection is there.
  std::string line(const Line& line) const;
  /// Retained: a component has that connection.
  std::string component(const Line& line, OwnerId id) const;
  /// Of one of the 16 parts of all presence: `shard` is one of kShards.
  std::string presence_filter(char shard) const;
  /// Of a component, whatever its connection.
  std::string component_filter(OwnerId id) const;
  /// Of a connection and its components.
  std::string line_filter(const Line& line) const;
  /// Of all connections of a user.
  std::string user_filter(std::string_view user) const;
  static constexpr std::string_view kShards = "0123456789abcdef";
  std::string inbox(const Line& to, const Line& from) const;
  std::string inbox_filter(const Line& own) const;
  /// In a name that no user has, in the own inbox and of presence: what comes from there, the broker's rights do not
  /// hold back. parse() does not know these topics.
  std::string inbox_probe(const Line& own) const;
  std::string presence_probe(const Line& own) const;
  /// Retained: a document that the user shows to all. parse() does not know this topic.
  std::string document(std::string_view user) const;
  std::string document_filter() const;
  /// nullopt: it is not a topic of a document.
  std::optional<std::string> user_of_document(std::string_view topic) const;

  struct Presence {
    Line line;
    std::optional<OwnerId> component;  ///< nullopt: of the connection itself
  };
  struct Inbox {
    Line to, from;
  };
  using Parsed = std::variant<std::monostate, Presence, Inbox>;
  /// monostate: none of ours.
  Parsed parse(std::string_view topic) const;

 private:
  std::string root_;
};

}  // namespace rubicon::tuples::mqtt
