#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/address.hpp"

namespace rubicon::tuples::peis {

enum class TroubleKind : std::uint8_t {
  kForeignNetwork,  ///< it belongs to another network
  kForeignVersion,  ///< it speaks another version of the protocol
  kUnreachable,     ///< it is known or configured, but the last attempt to connect failed
  kOwnId,           ///< it uses the id of this node
  kSharedId,        ///< a start of this id that ended is still there: two programs use the id
};

/// A program with which a node cannot exchange messages, or of which it cannot tell who it is.
struct Trouble {
  TroubleKind kind{};
  OwnerId id{};        ///< 0 = not known
  std::string name;    ///< `tupleview@desk!4711`, or its address; may be empty
  std::string detail;  ///< its network, an error, ...
  std::uint64_t times = 0;

  friend bool operator==(const Trouble&, const Trouble&) = default;
};

/// The last troubles of a node, for diagnosis: one for each kind, id and name, at most kMax.
class Troubles {
 public:
  static constexpr std::size_t kMax = 128;

  void note(TroubleKind kind, OwnerId id, std::string_view name, std::string_view detail);
  /// The program with this id, or by this address, was reached.
  void reached(OwnerId id, std::string_view address);
  const std::vector<Trouble>& all() const { return all_; }

 private:
  std::vector<Trouble> all_;  ///< the one that was noted last is the last
};

}  // namespace rubicon::tuples::peis
