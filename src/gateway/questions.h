#pragma once

#include <string_view>

namespace rubicon::gateway {

/// The type of questions about the past, to an island itself. Their receiver judges them by the right `read` for what
/// they ask, so that who came itself needs no `send`.
inline constexpr std::string_view kHistoryQuestion = "history.question";

}  // namespace rubicon::gateway
