#include <array>
#include <cstdlib>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "tuples/peis/fragments.h"

namespace rubicon::fuzz::peis_fragments_fuzz {

namespace {

using namespace rubicon::tuples::peis;

void require(bool condition) {
  if (!condition) std::abort();
}

Fragments::Limits small() {
  Fragments::Limits limits;
  limits.messages = 6;
  limits.messages_of_source = 4;
  limits.bytes = 8000;
  limits.bytes_of_source = 5000;
  limits.remembered = 40;
  return limits;
}

/// Headers as the input says: whatever comes, the limits hold and time gives all room back.
void hostile(base::ByteReader input) {
  VirtualScheduler time;
  Fragments fragments(time, small());
  Bytes body(kMaxBody);
  while (input.remaining() >= 8) {
    PackageHeader header;
    header.source = OwnerId{input.u8()};
    header.message = input.u8();
    header.fragments = input.u8();
    header.fragment = input.u8();
    header.ack_id = input.u8();
    header.port = Port{input.u8()};
    const auto step = input.u16_be();
    const auto whole = fragments.add(header, ByteView(body).first(step % (kMaxBody + 1)));
    if (whole && *whole) require((*whole)->size() <= std::size_t{header.fragments} * kMaxBody);
    require(fragments.incomplete() <= small().messages && fragments.bytes() <= small().bytes);
    if (step % 5 == 0) time.run_for(std::chrono::milliseconds(step));
    if (step % 97 == 0) fragments.forget(header.source);
  }
  time.run_for(kAssemblyTimeout);
  require(fragments.incomplete() == 0 && fragments.bytes() == 0);
}

/// A source that sends the parts of a message in any order and number, but as long as a kernel does, and that uses the
/// message id again only when all is forgotten.
class Sender {
 public:
  Sender(OwnerId source, std::uint16_t id) : source_(source), id_(id) {}

  void send(Fragments& fragments, std::uint8_t index, SteadyTime now) {
    if (now > first_ + kLife && now <= last_ + kMemory) return;
    if (now > first_ + kLife) begin(now);
    last_ = now;
    PackageHeader header;
    header.source = source_;
    header.message = id_;
    header.fragments = count_;
    header.fragment = index % count_;
    header.ack_id = base_ + header.fragment;
    const Bytes body(10, part(header.fragment));
    const auto whole = fragments.add(header, body);
    if (!whole || !*whole) return;
    require(!delivered_ && **whole == expected());
    delivered_ = true;
  }

 private:
  static constexpr auto kLife = std::chrono::milliseconds(11600), kMemory = std::chrono::milliseconds(12000);

  void begin(SteadyTime now) {
    first_ = now;
    ++generation_;
    base_ += 100;
    count_ = static_cast<std::uint16_t>(generation_ % 6 + 1);
    delivered_ = false;
  }
  std::uint8_t part(std::uint16_t index) const { return static_cast<std::uint8_t>(generation_ * 16U + index); }
  Bytes expected() const {
    Bytes bytes;
    for (std::uint16_t i = 0; i < count_; ++i) bytes.insert(bytes.end(), 10, part(i));
    return bytes;
  }

  OwnerId source_;
  std::uint16_t id_;
  std::uint16_t count_ = 1;
  std::uint32_t base_ = 0;
  unsigned generation_ = 0;
  bool delivered_ = false;
  SteadyTime first_ = SteadyTime::min(), last_ = SteadyTime::min();
};

/// Loss, order and duplicates as the input says: each message comes whole and once, or not at all.
void honest(base::ByteReader input) {
  VirtualScheduler time;
  Fragments fragments(time);
  std::array<Sender, 4> senders{Sender(OwnerId{1}, 1), Sender(OwnerId{1}, 2), Sender(OwnerId{2}, 1),
                                Sender(OwnerId{2}, 2)};
  while (input.remaining() >= 2) {
    const auto who = input.u8();
    const auto index = input.u8();
    if (who >= 128) time.run_for(std::chrono::milliseconds(50 * (who - 127)));
    senders[who % senders.size()].send(fragments, index, time.now());
  }
}

}  // namespace

/// Input: `h` for honest sources, which 2 bytes a package follow, or anything else, which 8 bytes a package follow.
FUZZ_TARGET(peis_fragments) {
  if (size == 0) return 0;
  const base::ByteReader input(ByteView(data + 1, size - 1));
  data[0] == 'h' ? honest(input) : hostile(input);
  return 0;
}

}  // namespace rubicon::fuzz::peis_fragments_fuzz
