#include <cstdlib>

#include "fuzz_target.h"
#include "networks/wsn/mote_messages.h"

namespace rubicon::fuzz::learning_json_fuzz {

namespace {

/// What is told of a message is a text that gives its bytes, unless a float in it is not a number.
void check_told(const motes::NetMessage& message, ByteView sound_record) {
  const auto told = networks::wsn::learning_json(message);
  if (!told) return;
  const auto again = networks::wsn::learning_message(*told);
  if (!again) {
    if (told->find("null") == std::string::npos) std::abort();
    return;
  }
  if (!sound_record.empty() && (again->record.size() > sound_record.size() ||
                                !std::equal(again->record.begin(), again->record.end(), sound_record.begin())))
    std::abort();
}

}  // namespace

/// Input: a text, and the same bytes as a record to and from a mote.
FUZZ_TARGET(learning_json) {
  const ByteView bytes(data, size);
  for (const std::uint16_t to : {std::uint16_t{5}, motes::kBaseMote}) {
    check_told({11, to, 11, 5, 0, 1, 0, motes::kTransportConnectionless, motes::kApplicationLearning, bytes}, {});
    check_told({11, to, 11, 5, 0, 1, 0, motes::kTransportSynaptic, motes::kApplicationSynaptic, bytes}, {});
    const auto message = networks::wsn::learning_message(base::as_text(bytes));
    if (!message) {
      if (message.error().text.empty() || message.error().text.size() > 1000) std::abort();
      continue;
    }
    if (message->transport == 0 || message->application == 0) std::abort();
    check_told({11, to, 11, 5, 0, 1, 0, message->transport, message->application, message->record}, message->record);
  }
  return 0;
}

}  // namespace rubicon::fuzz::learning_json_fuzz
