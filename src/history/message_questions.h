#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "gateway/gateway.h"
#include "gateway/questions.h"
#include "history/history_source.h"

namespace rubicon::history {

// Types of the messages between programs and the history of an island; their bytes are JSON (docs/history.md, "Ask an
// island").
inline constexpr std::string_view kQuestionTag = gateway::kHistoryQuestion;
inline constexpr std::string_view kAnswerTag = "history.answer";

/// What to_json() wrote. kInvalid: it is none. Gaps, and what was in force before, are left out.
Result<Answer> answer_from_json(std::string_view text);

/// Answers questions that other components send to the island: each once, by a message to who asked. Where there are
/// rights, the asker needs `read` for each series.
class MessageQuestions {
 public:
  static constexpr std::size_t kMaxAnswer = 200'000;  ///< bytes; a message has at most model::kMaxMessageBytes

  /// All must outlive it. `space`: of the island, whose rights hold.
  MessageQuestions(TupleSpace& space, gateway::Gateway& gateway, HistorySource& source);

 private:
  void take(const Message& message);
  Result<Question> read(const Message& message, std::string& id) const;
  void reply(const Address& to, const std::string& id, const Result<std::string>& answer);

  TupleSpace& space_;
  gateway::Gateway& gateway_;
  HistorySource& source_;
  std::uint64_t last_ = 0;
  std::map<std::uint64_t, Handle> open_;
  Handle listener_;
};

}  // namespace rubicon::history
