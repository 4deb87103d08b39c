#include <dds/dds.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "base/virtual_scheduler.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/entity.h"
#include "wire.h"

namespace rubicon::tuples::dds {
namespace {

/// A component of another process, as the wire sees it, that sends frames and never asks what became of them.
class Sender {
 public:
  Sender(const DdsOptions& options, OwnerId self, OwnerId to) {
    constexpr dds_domainid_t kInside = 229;  // of this process; on the wire it is that of the options
    domain_ = Entity(dds_create_domain(kInside, domain_xml(options).c_str()));
    participant_ = Entity(dds_create_participant(kInside, nullptr, nullptr));
    topic_ = Entity(dds_create_topic(participant_.get(), &rubicon_wire_Frame_desc, "rubicon_frames", nullptr, nullptr));
    auto group = make_qos();
    dds_qset_partition1(group.get(), (hex_id(self) + "." + hex_id(to)).c_str());
    publisher_ = Entity(dds_create_publisher(participant_.get(), group.get(), nullptr));
    auto qos = make_qos();
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
    writer_ = Entity(dds_create_writer(publisher_.get(), topic_.get(), qos.get(), nullptr));
  }

  void await_reader() const {
    dds_publication_matched_status_t status{};
    while (dds_get_publication_matched_status(writer_.get(), &status) == 0 && status.current_count == 0)
      dds_sleepfor(DDS_MSECS(1));
  }

  bool send(std::string text) const {
    rubicon_wire_Frame frame{};
    frame.content._maximum = frame.content._length = static_cast<std::uint32_t>(text.size());
    frame.content._buffer = reinterpret_cast<std::uint8_t*>(text.data());
    return dds_write(writer_.get(), &frame) == DDS_RETCODE_OK;
  }

 private:
  Entity domain_, participant_, topic_, publisher_, writer_;
};

/// The loop of this process takes nothing meanwhile: the receiving thread of DDS waits for room in the reader.
void fill(const Sender& sender) {
  for (int refused = 0; refused < 50;) {
    if (sender.send(std::string(1000, 'x'))) continue;
    ++refused;
    dds_sleepfor(DDS_MSECS(2));
  }
}

TEST(FullReader, HoldsUpNoDeletionOfAnotherLink) {
  VirtualScheduler time;
  DdsTestEcology here(time);
  auto full = here.join(OwnerId(7)).value();
  auto other = here.join(OwnerId(8)).value();
  const Sender sender(here.options(), OwnerId(9), OwnerId(7));
  sender.await_reader();
  fill(sender);
  ::alarm(60);  // it would wait for ever
  other.reset();
  full.reset();
  ::alarm(0);
}

}  // namespace
}  // namespace rubicon::tuples::dds
