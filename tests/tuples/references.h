#pragma once

#include <gtest/gtest.h>

#include "tuples/component.h"
#include "tuples/meta_tuple.h"

namespace rubicon::tuples {

/// The island owns targets, the robot meta tuples.
struct MetaTuples : testing::Test, TwoComponents {
  TupleName here(std::string key) const { return {kIsland, std::move(key)}; }
  TupleName there(std::string key) const { return {kRobot, std::move(key)}; }
  /// Sets a reference without asking whether it makes sense.
  void point(TupleSpace& space, std::string_view key, const TupleName& target) {
    ASSERT_TRUE(space.set(key, to_string(target), {.media_type = kReferenceMediaType}));
  }
  void link(std::string_view key, const TupleName& target) {
    const auto ok = set_reference(robot->space, key, target);
    ASSERT_TRUE(ok) << ok.error().text;
  }
  Handle see(std::string_view keys) {
    return robot->space.subscribe(pattern(keys), {.passive = true}, [](const Event&) {});
  }
};

}  // namespace rubicon::tuples
