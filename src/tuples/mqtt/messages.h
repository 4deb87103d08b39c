#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/bytes.h"
#include "rubicon/result.hpp"
#include "rubicon/summary.hpp"
#include "tuples/distant/frame_codec.h"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace rubicon::tuples::mqtt {

/// Version of topics, presence and frames (docs/sites.md).
inline constexpr std::uint8_t kProtocolVersion = 1;
/// Of a retained message.
inline constexpr std::size_t kMaxPresence = kMaxSummary + 1024;

/// What stands at the topic of a connection.
struct LineShown {
  std::uint64_t count = 0;  ///< of the connections of that process: a later one has a higher number
  Duration lease{};         ///< how long its components are taken for present after it was seen last
};
/// What stands at the topic of a component.
struct ComponentShown {
  std::uint64_t incarnation = 0;
  std::string host, summary;
};

std::string line_text(const LineShown& shown);
std::string component_text(const ComponentShown& shown);
/// kInvalid: malformed; kUnsupported: of another version of the protocol, which the text names.
Result<LineShown> read_line(std::string_view payload);
Result<ComponentShown> read_component(std::string_view payload);
/// Said at the topic of a component, and not retained: it leaves.
inline constexpr std::string_view kLeft("\0", 1);

/// What stands before the entries of a frame.
struct FrameHead {
  OwnerId source{}, target{};
  std::uint64_t source_incarnation = 0, target_incarnation = 0;
  /// The frames that go one way are numbered from 1 in each stream; 0 = a frame outside of it, which is not repeated.
  std::uint64_t stream = 0, number = 0;
  std::uint64_t first = 0;  ///< the lowest number that the sender still has
  /// What it received of the other way: all up to that number of that stream.
  std::uint64_t heard_stream = 0, heard = 0;
  std::uint32_t credit = 0;  ///< how many frames may be under way to the sender
  bool again = false;        ///< frames are missing: all behind `heard` should be sent again
};

/// Head and entries.
Bytes frame_of(const FrameHead& head, ByteView entries);
/// `entries` becomes what follows the head. kInvalid, kUnsupported as above.
Result<FrameHead> read_head(ByteView frame, ByteView& entries);

/// Makes the entries of large frames smaller: lists of devices shrink to less than a fifth. Packed entries are one zstd
/// frame with its content size (RFC 8878). A reader recognises it by its first byte: no entry begins with that.
class Packing {
 public:
  Packing();
  ~Packing();

  /// The same in fewer bytes; nullopt: it stays as it is.
  std::optional<Bytes> packed(ByteView entries);
  /// The entries, in `into` if they were packed. kInvalid: damaged, or beyond kMaxUnpacked.
  Result<ByteView> unpacked(ByteView received, Bytes& into);

  /// Smaller ones would gain little.
  static constexpr std::size_t kMinPacked = 1024;
  /// The largest value and what goes with it.
  static constexpr std::size_t kMaxUnpacked = std::size_t{2} << 20;

 private:
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> packer_;
  std::unique_ptr<ZSTD_DCtx_s, std::size_t (*)(ZSTD_DCtx_s*)> unpacker_;
};

}  // namespace rubicon::tuples::mqtt
