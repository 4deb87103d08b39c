#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "rubicon/tuple_space.hpp"
#include "tuples/member.h"

namespace rubicon::tuples {

/// Who the users of a broker are, by a signed document that the members hand on to each other: whoever brings the
/// newest one, its signature counts. Implemented by `trust`; outlives the ecology.
class UserRealm {
 public:
  static constexpr std::size_t kMaxDocument = 256UL * 1024;  ///< bytes
  enum class Taken : std::uint8_t { kNewer, kOlder, kWrong };

  virtual ~UserRealm() = default;
  /// nullptr: nobody, or shut out. Fast. Equal pointers as long as nothing changes for that user.
  virtual std::shared_ptr<const Member> member(std::string_view user) const = 0;
  /// The newest one, at most kMaxDocument bytes.
  virtual const std::string& document() const = 0;
  /// Another one, which `from` brought. kNewer: it counts from now on, and those that watch() were told.
  virtual Taken take(std::string_view document, std::string_view from) = 0;
  /// `call` runs after each change, also if the newer one was found on the disk. Calls are made in the order in which
  /// they were asked for.
  [[nodiscard]] virtual Handle watch(std::function<void()> call) = 0;
};

}  // namespace rubicon::tuples
