#include "tuples/peis/packages.h"

namespace rubicon::tuples::peis {

void PackageStream::append(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<ConnectMessage>> PackageStream::connect() {
  if (fault_) return fail(*fault_);
  if (rest().size() < kConnectSize) return std::nullopt;
  auto message = read_connect(rest().first(kConnectSize));
  if (!message) {
    fault_ = message.error();
    return fail(*fault_);
  }
  begin_ += kConnectSize;
  return std::move(*message);
}

Result<std::optional<Package>> PackageStream::next() {
  if (fault_) return fail(*fault_);
  const auto bytes = rest();
  if (bytes.size() < kHeaderSize) return std::nullopt;
  const auto header = read_package_header(bytes);
  if (!header) {
    fault_ = header.error();
    return fail(*fault_);
  }
  const auto size = kHeaderSize + header->length;
  if (bytes.size() < size) return std::nullopt;
  begin_ += size;
  return Package{*header, bytes.subspan(kHeaderSize, header->length)};
}

}  // namespace rubicon::tuples::peis
