#include "model/message_fields.h"

#include <gtest/gtest.h>

namespace rubicon::model {
namespace {

Opaque request_of(const std::string& text) {
  return {"knx.request", {text.begin(), text.end()}};
}

TEST(ToolRequest, IsAJsonObject) {
  const auto good = read_tool_request(request_of(R"({"do":"read"})"));
  ASSERT_TRUE(good) << good.error().text;
  EXPECT_EQ(good->value("do", ""), "read");
  for (const auto* text : {"", "{", "[1]", "7", "\xff"}) {
    const auto bad = read_tool_request(request_of(text));
    ASSERT_FALSE(bad) << text;
    EXPECT_EQ(bad.error().code, ErrorCode::kInvalid);
    EXPECT_EQ(bad.error().text, "a knx.request is a JSON object");
  }
}

TEST(ToolRequest, HasABoundOfBytes) {
  const std::string longest = "{}" + std::string(kMaxToolRequest - 2, ' ');
  EXPECT_TRUE(read_tool_request(request_of(longest)));
  const auto longer = read_tool_request(request_of(longest + ' '));
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().text, "a knx.request of 65537 bytes, expected at most 65536");
}

}  // namespace
}  // namespace rubicon::model
