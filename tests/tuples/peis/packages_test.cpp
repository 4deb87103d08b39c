#include "tuples/peis/packages.h"

#include <gtest/gtest.h>

namespace rubicon::tuples::peis {
namespace {

const Bytes kSubscribeHeader =
    base::from_hex("ff00aa00 2b25e0f2 00000003 0a152142 0001 02 01 00000066 00000065 0005 00e4 0000 0000 0000 2020")
        .value();

TEST(PeisPackages, TheHeaderOfTheReferenceIsRead) {
  const auto header = read_package_header(kSubscribeHeader);
  ASSERT_TRUE(header) << header.error().text;
  EXPECT_EQ(header->id, 0x2b25e0f2U);
  EXPECT_TRUE(header->wants_ack());
  EXPECT_EQ(header->port, Port::kSubscribe);
}

}  // namespace
}  // namespace rubicon::tuples::peis
