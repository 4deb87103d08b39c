#pragma once

#include <string>
#include <string_view>

#include "rubicon/tuple.hpp"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

/// A value as tuples on the wire carry it.
struct WireValue {
  Encoding encoding = Encoding::kAscii;
  std::string data;  ///< not empty
};

/// Text (media type `text/...`, or UTF-8 without NUL) is ASCII with one NUL more, as the string functions of kernels
/// store it (peis.md, section 1.1); an empty value is one NUL, since kernels drop tuples without data (section 6.2, 9).
WireValue to_wire(std::string_view value, std::string_view media_type);

/// The opposite, for what a component of ours sent: exactly the value that to_wire() received.
std::string_view from_wire(Encoding encoding, std::string_view data);

/// The same for what a kernel sent. It keeps the encoding of the first set (section 6.2, 18), so that ASCII may be
/// binary: data with another NUL inside is left as it is, unless the media type is `text/...`.
std::string_view from_kernel(Encoding encoding, std::string_view data, std::string_view media_type);

/// The data of a tuple after an append, as kernels do it (section 1.6): ASCII replaces the trailing NUL.
std::string appended(Encoding encoding, std::string_view data, std::string_view difference);

/// The creator of a tuple on the wire: the owner for one without an id, or with an id above 2^31-1, which kernels take
/// for a negative one. Components of the other engines may have such ids.
OwnerId creator_on_wire(OwnerId creator, OwnerId owner);

/// `text/plain` for none, cut to kMaxMediaType bytes.
std::string_view media_type_on_wire(std::string_view media_type);

/// An own tuple without its sequence. It refers to the texts of both arguments, which must outlive it.
NetworkTuple tuple_on_wire(const TupleView& tuple, const WireValue& value, OwnerId self);

}  // namespace rubicon::tuples::peis
