#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/peis/wire.h"

namespace rubicon::fuzz::peis_announcement_fuzz {

namespace {

using namespace rubicon::tuples;

/// What was read is written as something that reads the same.
template <class Message>
void check(const Result<Message>& once, Result<Message> (*read)(ByteView)) {
  if (!once) {
    if (once.error().text.empty()) std::abort();
    return;
  }
  const auto twice = read(peis::write(*once));
  if (!twice || !(*twice == *once)) std::abort();
}

}  // namespace

/// Input: a datagram of discovery, the begin of a connection, or the body of a HOSTINFO, which the length tells apart.
FUZZ_TARGET(peis_announcement) {
  const ByteView input(data, size);
  check(peis::read_announcement(input), peis::read_announcement);
  check(peis::read_connect(input), peis::read_connect);
  check(peis::read_host_info(input), peis::read_host_info);
  return 0;
}

}  // namespace rubicon::fuzz::peis_announcement_fuzz
