#include "networks/knx/line/frame_stream.h"

#include <fmt/format.h>

namespace rubicon::networks::knx::line {

void FrameStream::append(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<ByteView> FrameStream::next() {
  const auto rest = ByteView(buffer_).subspan(begin_);
  const auto size = wire::frame_size(rest);
  if (!size) return fail(size.error());
  if (*size > kMaxFrame)
    return fail(ErrorCode::kInvalid, fmt::format("KNXnet/IP total length {}, expected at most {}", *size, kMaxFrame));
  if (*size == 0 || *size > rest.size()) return ByteView{};
  begin_ += *size;
  return rest.first(*size);
}

void FrameStream::clear() {
  buffer_.clear();
  begin_ = 0;
}

}  // namespace rubicon::networks::knx::line
