#include <cstdlib>

#include "fuzz_target.h"
#include "tuples/distant/frame_codec.h"

namespace rubicon::fuzz::dds_frame_fuzz {

namespace {

using namespace rubicon::tuples;

/// Writes down again what it is told.
struct Copy final : distant::FrameReader {
  void on_changes(std::span<const Change> changes) override {
    for (const auto& change : changes) frame.add(change);
  }
  void on_set(RemoteSet&& set) override { frame.add(set); }
  void on_reply(Reply&& reply) override { frame.add(reply); }
  void on_identity_check(const distant::IdentityCheck& check) override { frame.add(check); }
  void on_times(const distant::FrameTimes& times) override { frame.add(times); }
  void on_subscription(SubscriptionSpec&& spec) override { frame.add_subscription(spec); }
  void on_unsubscription(std::uint32_t id) override { frame.add_unsubscription(id); }

  distant::FrameWriter frame;
};

}  // namespace

/// Input: the content of a frame, and of an interest. What was understood must be understood alike once more.
FUZZ_TARGET(dds_frame) {
  const ByteView input(data, size);
  Copy once;
  const auto read = distant::read_frame(input, OwnerId{1}, OwnerId{2}, once);
  if (!read && read.error().text.empty()) std::abort();
  Copy twice;
  if (!distant::read_frame(once.frame.view(), OwnerId{1}, OwnerId{2}, twice)) std::abort();
  if (base::as_text(once.frame.view()) != base::as_text(twice.frame.view())) std::abort();
  const auto spec = distant::read_subscription(input);
  if (!spec) return 0;
  distant::FrameWriter content;
  content.add(*spec);
  const auto again = distant::read_subscription(content.view());
  if (!again || again->id != spec->id || !(again->pattern == spec->pattern)) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::dds_frame_fuzz
