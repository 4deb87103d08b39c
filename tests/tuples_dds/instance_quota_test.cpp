#include "tuples/dds/instance_quota.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>

#include "daemon/private_network.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/writers.h"
#include "wire.h"

namespace rubicon::tuples::dds {
namespace {

/// A reader with a quota of three instances, and a writer of another participant.
struct Quota : testing::Test {
  Quota() {
    static const daemon::PrivateNetwork alone;
    options.tag = "quota-" + std::to_string(::getpid());
    domain = Entity(dds_create_domain(options.domain, domain_xml(options).c_str()));
    for (auto* participant : {&here, &there}) *participant = Entity(dds_create_participant(0, nullptr, nullptr));
    topic_here = topic(here);
    topic_there = topic(there);
    EXPECT_TRUE(quota.guard(topic_here.get()));
    reader = Entity(dds_create_reader(here.get(), topic_here.get(), make_kept_qos().get(), nullptr));
    writer = Entity(dds_create_writer(there.get(), topic_there.get(), make_kept_qos().get(), nullptr));
    for (int i = 0; i < 1000 && matched_writers({reader.get()}).empty(); ++i) dds_sleepfor(DDS_MSECS(10));
  }
  static Entity topic(const Entity& participant) {
    return Entity(
        dds_create_topic(participant.get(), &rubicon_wire_Interest_desc, "rubicon_interests", nullptr, nullptr));
  }
  void write(std::uint32_t slot) {
    rubicon_wire_Interest one{};
    one.slot = slot;
    dds_write(writer.get(), &one);
  }
  void end(std::uint32_t slot) {
    rubicon_wire_Interest one{};
    one.slot = slot;
    dds_dispose(writer.get(), &one);
    dds_unregister_instance(writer.get(), &one);
  }
  /// The slot of the next valid sample; what ended before it is released.
  std::optional<std::uint32_t> next() {
    for (int i = 0; i < 100; ++i, dds_sleepfor(DDS_MSECS(10))) {
      void* samples[1] = {};
      dds_sample_info_t infos[1];
      while (dds_take(reader.get(), samples, infos, 1, 1) == 1) {
        const auto slot = static_cast<const rubicon_wire_Interest*>(samples[0])->slot;
        const auto info = infos[0];
        dds_return_loan(reader.get(), samples, 1);
        if (info.instance_state != DDS_IST_ALIVE) quota.release(info.publication_handle, info.instance_handle);
        if (info.valid_data) return slot;
      }
    }
    return std::nullopt;
  }

  DdsOptions options;
  InstanceQuota quota{3};
  Entity domain, here, there, topic_here, topic_there, reader, writer;
};

TEST_F(Quota, KeepsWhatIsBeyondItOutOfTheReader) {
  for (const std::uint32_t slot : {1U, 2U, 3U, 4U, 5U}) write(slot);
  for (const std::uint32_t slot : {1U, 2U, 3U}) EXPECT_EQ(next(), slot);
  write(2);
  EXPECT_EQ(next(), 2U) << "what it has may change";
  EXPECT_EQ(next(), std::nullopt);
}

TEST_F(Quota, IsNotUsedUpByWhatEnded) {
  for (std::uint32_t slot = 0; slot < 20; ++slot) {
    write(slot);
    EXPECT_EQ(next(), slot);
    end(slot);
  }
}

TEST_F(Quota, TakesNothingOfABannedWriter) {
  write(1);
  ASSERT_EQ(next(), 1U);
  quota.ban(*matched_writers({reader.get()}).begin());
  write(1);
  write(2);
  EXPECT_EQ(next(), std::nullopt);
}

}  // namespace
}  // namespace rubicon::tuples::dds
