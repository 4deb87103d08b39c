#include "apps/rubicon-proxy/duplicate_id.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rubicon/summary.hpp"

namespace rubicon::daemon {
namespace {

TEST(Displaced, NamesTheProcessThatHasTheIdAndTheWaysOut) {
  model::Summary holder;
  holder.name = "home";
  holder.host = "attic";
  holder.program = "rubicon-proxy 0.1.0";
  tuples::dds::ComponentStart other, gone;
  other.id = gone.id = OwnerId(6541);
  other.present = true;
  other.summary = model::to_json(holder);
  gone.summary = "{}";
  auto console = holder;
  console.name = kConsole;
  console.program = "pid 4711 of anna";
  tuples::dds::ComponentStart beside;
  beside.id = OwnerId(70016 + 6541 % 128);
  beside.present = true;
  beside.summary = model::to_json(console);
  EXPECT_EQ(displaced_text(OwnerId(6541), {gone, other, beside}),
            "component id 6541 is in use by another process, pid 4711 of anna on attic: stop that one, "
            "or give this island another id (`island.id`, or --set island.id=6542); exiting");
  console.host = "cellar";
  beside.summary = model::to_json(console);
  EXPECT_THAT(displaced_text(OwnerId(6541), {other, beside}),
              testing::HasSubstr("process, rubicon-proxy 0.1.0 on attic"));
  EXPECT_EQ(displaced_text(OwnerId(65532), {}),
            "component id 65532 is in use by another process: stop that one, or give this island another id "
            "(`island.id`, or --set island.id=1); exiting");
  EXPECT_EQ(displaced_text(OwnerId(70000), {}), "component id 70000 is in use by another process; exiting");
}

}  // namespace
}  // namespace rubicon::daemon
