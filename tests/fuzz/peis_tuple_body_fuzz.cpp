#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/peis/own_messages.h"
#include "tuples/peis/rewritten.h"

namespace rubicon::fuzz::peis_tuple_body_fuzz {

namespace {

using namespace rubicon::tuples::peis;

constexpr Port kPorts[] = {Port::kPush,        Port::kSetRemote, Port::kSubscribe,
                           Port::kUnsubscribe, Port::kSetAppend, Port::kPushAppended};

void check_annex(ByteView bytes) {
  Annex annex{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), annex.size()), annex.begin());
  if (const auto fields = read_subscribe_annex(annex); fields && read_subscribe_annex(to_annex(*fields)) != fields)
    std::abort();
  if (const auto fields = read_set_annex(annex); fields && read_set_annex(to_annex(*fields)) != fields) std::abort();
}

/// Whether the parts that were read lie in the body.
void check_views(ByteView body, const NetworkTuple& tuple) {
  const auto inside = [&](std::string_view part) {
    const auto* begin = reinterpret_cast<const char*>(body.data());
    return part.empty() || (part.data() >= begin && part.data() + part.size() <= begin + body.size());
  };
  if (!inside(tuple.key) || !inside(tuple.media_type) || !inside(tuple.data.value_or(std::string_view()))) std::abort();
  if (tuple.key.size() > kMaxPeisKey || tuple.media_type.size() > kMaxMediaType) std::abort();
}

}  // namespace

/// Input: which message with a tuple, then its body. What was read is written as something that reads the same, in as
/// many bytes.
FUZZ_TARGET(peis_tuple_body) {
  if (size == 0) return 0;
  const auto port = kPorts[data[0] % std::size(kPorts)];
  const ByteView body(data + 1, size - 1);
  check_annex(body);
  const auto once = rewritten(port, body);
  if (!*once) {
    if (once->error().text.empty()) std::abort();
    return 0;
  }
  if ((*once)->size() != body.size()) std::abort();
  if (port == Port::kPush) check_views(body, read_push(body).value());
  if (port == Port::kSubscribe) check_views(body, read_subscribe(body).value().prototype);
  const auto twice = rewritten(port, **once);
  if (!*twice || **twice != **once) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::peis_tuple_body_fuzz
