#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/key.hpp"
#include "web/exchange.h"

namespace rubicon::web::api {

/// The parameters of the query of a request. Keeps the first fault: which parameter, its value, and what was expected.
/// The getters return the default after a fault.
class Query {
 public:
  explicit Query(const Request& request) : request_(request) {}

  bool has(std::string_view name);
  std::string text(std::string_view name);
  /// Each value of a parameter that may be given several times.
  std::vector<std::string> texts(std::string_view name);
  std::uint64_t count(std::string_view name, std::uint64_t otherwise, std::uint64_t least, std::uint64_t most);
  std::optional<std::uint64_t> count(std::string_view name);
  double number(std::string_view name, double otherwise, double least, double most);
  /// `5s`, `250ms`
  Duration duration(std::string_view name, Duration otherwise, Duration longest);
  /// Seconds since 1970, or a time before now: `-1h`.
  WallTime time(std::string_view name, WallTime otherwise, WallTime now);
  bool flag(std::string_view name);
  /// Has to be there.
  Pattern pattern(std::string_view name);

  /// The first fault, or a parameter that no getter has asked for.
  Result<void> end();
  void fault(std::string text);

 private:
  const std::string* find(std::string_view name);
  void wrong(std::string_view name, std::string_view got, std::string_view expected);

  const Request& request_;
  std::vector<std::string> known_;
  std::optional<Error> fault_;
};

}  // namespace rubicon::web::api
