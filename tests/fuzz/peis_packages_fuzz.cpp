#include <cstdlib>
#include <vector>

#include "fuzz_target.h"
#include "tuples/peis/connection.h"
#include "tuples/peis/rewritten.h"

namespace rubicon::fuzz::peis_packages_fuzz {

namespace {

using namespace rubicon::tuples::peis;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A package that was read is written as the same bytes, but for the padding of its header.
Bytes again(const Package& package) {
  require(package.header.length == package.body.size() && package.body.size() <= kMaxBody);
  Bytes bytes;
  append_package(bytes, package.header, package.body);
  const auto header = read_package_header(bytes);
  require(header && *header == package.header);
  if (const auto body = rewritten(package.header.port, package.body); body && !*body)
    require(!body->error().text.empty());
  return bytes;
}

/// All packages of a stream that comes in pieces, and the error that ends it.
std::vector<Bytes> packages_of(ByteView bytes, std::size_t piece, bool accepted) {
  PackageStream stream;
  std::vector<Bytes> all;
  bool connected = !accepted;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    stream.append(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    if (!connected) {
      const auto message = stream.connect();
      if (!message) break;
      connected = message->has_value();
      if (connected) all.push_back(write(**message));
    }
    if (!connected) continue;
    for (;;) {
      const auto package = stream.next();
      if (!package) {
        require(!package.error().text.empty() && stream.next().error() == package.error());
        const auto text = package.error().text;
        all.emplace_back(text.begin(), text.end());
        return all;
      }
      if (!*package) break;
      all.push_back(again(**package));
    }
    require(stream.pending() < kHeaderSize + kMaxBody);
  }
  return all;
}

}  // namespace

/// Input: 1 for a connection that was accepted and begins with a connect message, then the bytes of the stream. In
/// whatever pieces they come, the packages are the same.
FUZZ_TARGET(peis_packages) {
  if (size == 0) return 0;
  const ByteView bytes(data + 1, size - 1);
  const bool accepted = data[0] == 1;
  const auto whole = packages_of(bytes, size, accepted);
  require(packages_of(bytes, 7, accepted) == whole);
  require(packages_of(bytes, 1064, accepted) == whole);
  return 0;
}

}  // namespace rubicon::fuzz::peis_packages_fuzz
