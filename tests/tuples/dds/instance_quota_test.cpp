#include "tuples/dds/reader_stores.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>

#include "support/private_network.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/entity.h"
#include "wire.h"

namespace rubicon::tuples::dds {
namespace {

/// A reader with a quota of three instances, and a writer of another participant.
struct Quota : testing::Test {
  Quota() {
    static const support::PrivateNetwork alone;
    options.tag = "quota-" + std::to_string(::getpid());
    domain = Entity(dds_create_domain(options.domain, domain_xml(options).c_str()));
    for (auto* participant : {&here, &there}) *participant = Entity(dds_create_participant(0, nullptr, nullptr));
    topic_here = topic(here);
    topic_there = topic(there);
    EXPECT_TRUE(bound_interests(topic_here.get(), quota));
    reader = Entity(dds_create_reader(here.get(), topic_here.get(), make_kept_qos().get(), nullptr));
    writer = new_writer();
  }
  static Entity topic(const Entity& participant) {
    return Entity(
        dds_create_topic(participant.get(), &rubicon_wire_Interest_desc, "rubicon_interests", nullptr, nullptr));
  }
  /// Of the other participant, when the reader knows it.
  Entity new_writer() {
    const auto before = matched_writers({reader.get()}).size();
    Entity one(dds_create_writer(there.get(), topic_there.get(), make_kept_qos().get(), nullptr));
    until([&] { return matched_writers({reader.get()}).size() > before; });
    return one;
  }
  template <class Done>
  static bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) dds_sleepfor(DDS_MSECS(10));
    return done();
  }
  static rubicon_wire_Interest interest(std::uint32_t slot) {
    rubicon_wire_Interest one{};
    one.slot = slot;
    return one;
  }
  void write(std::uint32_t slot) const { write(writer, slot); }
  void write(std::uint32_t slot, Bytes content) const {
    auto one = interest(slot);
    one.content._length = one.content._maximum = static_cast<std::uint32_t>(content.size());
    one.content._buffer = content.data();
    dds_write(writer.get(), &one);
  }
  static void write(const Entity& with, std::uint32_t slot) {
    const auto one = interest(slot);
    dds_write(with.get(), &one);
  }
  void dispose(std::uint32_t slot) const {
    const auto one = interest(slot);
    dds_dispose(writer.get(), &one);
  }
  void end(std::uint32_t slot) const {
    dispose(slot);
    const auto one = interest(slot);
    dds_unregister_instance(writer.get(), &one);
  }
  /// Takes one. False: there is none.
  bool take_one(std::optional<std::uint32_t>& slot) {
    void* samples[1] = {};
    dds_sample_info_t infos[1];
    if (dds_take(reader.get(), samples, infos, 1, 1) != 1) return false;
    quota.taken(infos[0].publication_handle, infos[0].instance_handle);
    if (infos[0].valid_data) slot = static_cast<const rubicon_wire_Interest*>(samples[0])->slot;
    dds_return_loan(reader.get(), samples, 1);
    if (infos[0].instance_state != DDS_IST_ALIVE) quota.ended(infos[0].publication_handle, infos[0].instance_handle);
    return true;
  }
  /// The slot of the next valid sample.
  std::optional<std::uint32_t> next() {
    std::optional<std::uint32_t> slot;
    for (int i = 0; i < 100 && !slot; ++i, dds_sleepfor(DDS_MSECS(10))) {
      while (!slot && take_one(slot)) {
      }
    }
    return slot;
  }
  /// How many of the first slots the reader has an instance of, taken or not.
  int kept(std::uint32_t slots) const {
    int count = 0;
    for (std::uint32_t slot = 0; slot < slots; ++slot) {
      const auto one = interest(slot);
      const auto handle = dds_lookup_instance(reader.get(), &one);  // 0: nobody in this process has it
      void* samples[1] = {};
      dds_sample_info_t infos[1];
      const auto found = dds_read_instance(reader.get(), samples, infos, 1, 1, handle);
      count += found >= 0;
      if (found > 0) dds_return_loan(reader.get(), samples, found);
    }
    return count;
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
  EXPECT_EQ(kept(6), 3);
}

TEST_F(Quota, IsNotUsedUpByWhatEnded) {
  for (std::uint32_t slot = 0; slot < 20; ++slot) {
    write(slot);
    EXPECT_EQ(next(), slot);
    end(slot);
  }
}

TEST_F(Quota, IsOfEachWriter) {
  const auto other = new_writer();
  for (const std::uint32_t slot : {1U, 2U, 3U, 4U}) write(slot);
  for (const std::uint32_t slot : {1U, 2U, 3U}) EXPECT_EQ(next(), slot);
  write(other, 5);
  EXPECT_EQ(next(), 5U) << "of one that does not know how many the other has";
}

TEST_F(Quota, CountsBytesUntilTheyAreTaken) {
  const Bytes most(InstanceQuota::kMaxWaitingBytes * 5 / 8);
  write(0, most);
  write(0, most);
  write(1, most);
  EXPECT_EQ(next(), 0U) << "which replaces the first of its instance";
  EXPECT_EQ(next(), std::nullopt);
  write(1, most);
  EXPECT_EQ(next(), 1U);
}

TEST(InstanceQuota, AValueThatWaitsIsReplacedByOneOfEqualSize) {
  InstanceQuota bytes(3);
  EXPECT_TRUE(bytes.add(1, 7, InstanceQuota::kMaxWaitingBytes));
  EXPECT_TRUE(bytes.add(1, 7, InstanceQuota::kMaxWaitingBytes));
  EXPECT_FALSE(bytes.add(1, 8, 1));
}

TEST(InstanceQuota, WhatEndsFreesTheBytesOfItsValue) {
  InstanceQuota bytes(3);
  ASSERT_TRUE(bytes.add(1, 7, InstanceQuota::kMaxWaitingBytes));
  bytes.ended(1, 7);
  EXPECT_TRUE(bytes.add(1, 8, InstanceQuota::kMaxWaitingBytes));
}

/// DDS asks no filter about the end of an instance: decision 029.
TEST_F(Quota, WhatIsOnlyDisposedGoesWithItsWriter) {
  for (std::uint32_t slot = 0; slot < 20; ++slot) dispose(slot);
  write(99);
  EXPECT_EQ(next(), 99U);
  EXPECT_EQ(quota.writers(), 1U);
  writer.reset();
  EXPECT_TRUE(until([&] { return kept(20) == 0; }));
}

TEST_F(Quota, ForgetsWritersThatAreGone) {
  write(1);
  EXPECT_EQ(next(), 1U);
  EXPECT_EQ(quota.writers(), 1U);
  quota.keep_only(matched_writers({reader.get()}));
  EXPECT_EQ(quota.writers(), 1U);
  writer.reset();
  EXPECT_TRUE(until([&] { return matched_writers({reader.get()}).empty(); }));
  quota.keep_only(matched_writers({reader.get()}));
  EXPECT_EQ(quota.writers(), 0U);
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
