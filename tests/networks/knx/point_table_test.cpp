#include "networks/knx/point_table.h"

#include <gtest/gtest.h>

namespace rubicon::networks::knx {
namespace {

groups::GroupPoint group_point(std::string_view address, std::string device = {}) {
  groups::GroupPoint point;
  point.address = wire::parse_group(address).value();
  point.dpt = dpt::DptId{1, 1};
  point.device = std::move(device);
  point.name = "Hall light";
  return point;
}

TEST(Points, NameADeviceOfOneAddressAndNoneThatHasItsOwnId) {
  const TypeCatalogue types;
  const PointTable table({group_point("1/0/1"), group_point("1/0/2", "hall")}, types);
  EXPECT_EQ(table.join_of("1/0/1").name, "Hall light");
  EXPECT_EQ(table.join_of("hall").name, "") << "the names of points are not the name of their device";
}

TEST(Points, AreHeardOnceOnEachAddress) {
  auto point = group_point("1/0/1");
  point.listen = {wire::parse_group("0/0/1").value(), point.address, wire::parse_group("0/0/1").value()};
  const TypeCatalogue types;
  const PointTable table({point, group_point("1/0/2")}, types);
  EXPECT_EQ(table.listeners_of(point.address).size(), 1U);
  EXPECT_EQ(table.listeners_of(wire::parse_group("0/0/1").value()).size(), 1U);
  EXPECT_EQ(table.listeners_of(wire::parse_group("1/0/2").value())[0].point, 1U);
  EXPECT_TRUE(table.listeners_of(wire::parse_group("1/0/3").value()).empty());
}

}  // namespace
}  // namespace rubicon::networks::knx
